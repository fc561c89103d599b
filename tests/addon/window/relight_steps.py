"""In a window: maps are imported, relit, keyed; one garment is picked by a click and edited; the photograph comes behind;
picture, maps and GLB are written. Arguments: folder for pictures, an environment."""
import os
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.dirname(HERE)]

import bpy  # noqa: E402
import driver  # noqa: E402
import support  # noqa: E402,F401
from bpy_extras import view3d_utils  # noqa: E402
from support import image_files, maps_folder  # noqa: E402

import human_material  # noqa: E402
from human_material.services import edit, environment, relief  # noqa: E402

SIZE = 96


class Dressed(maps_folder.Person):
    """A blue shirt above grey trousers, a head of skin."""

    def class_of(self, x, y):
        return 0 if self.place(x, y)[1] > 0.4 else 2

    def color(self, x, y):
        return (0.6, 0.4, 0.3) if self.class_of(x, y) == 0 else (0.1, 0.2, 0.6) if self.place(x, y)[1] > -0.1 else (
            0.35, 0.35, 0.35)

    def maps(self):
        return {**super().maps(), "diffuse": self.raster(self.color)}


def on_screen(window, item, u, v):
    """Where a place of the maps (0 to 1) is in the view's region."""
    uv = item.data.uv_layers.active.data
    loop = min(range(len(uv)), key=lambda k: (uv[k].uv[0] - u) ** 2 + (uv[k].uv[1] - v) ** 2)
    world = item.matrix_world @ item.data.vertices[item.data.loops[loop].vertex_index].co
    return view3d_utils.location_3d_to_region_2d(window.region(), window.view(), world)


def relit(window, folder, sky):
    """Imported, lit and keyed by the panel's own settings."""
    maps_folder.write(os.path.join(folder, "person"), Dressed(SIZE, SIZE))
    photo = os.path.join(folder, "photo.png")
    image_files.png(photo, SIZE, SIZE, [c for y in range(SIZE) for x in range(SIZE) for c in (90, 110 + y, 200 - y)],
                    3, 8)
    yield
    window.area.spaces.active.show_region_ui = True
    with window.override():
        bpy.ops.hm.import_maps("EXEC_DEFAULT", filepath=os.path.join(folder, "person", "maps.json"))
        bpy.ops.hm.set_environment("EXEC_DEFAULT", filepath=sky)
    item = bpy.context.view_layer.objects.active
    assert relief.is_relief(item)
    yield from window.click_window(1044, 272)
    settings = bpy.context.scene.hm
    for frame, degrees in ((1, 0.0), (11, 100.0)):
        settings.rotation_deg = degrees
        settings.keyframe_insert("rotation_deg", frame=frame)
    bpy.context.scene.frame_set(6)
    yield
    turned = environment.world_nodes(bpy.context.scene)[environment.MAPPING].inputs["Rotation"].default_value[2]
    assert abs(turned) > 0.1, turned   # the world follows the keys
    yield from window.picture("1_imported")
    window.move(300, 300)
    yield
    with window.override():
        bpy.ops.hm.rotate_light("INVOKE_DEFAULT")
    yield
    window.move(340, 300)
    yield
    window.move(380, 300)
    yield
    assert abs(bpy.context.scene.hm.rotation_deg - 50) > 5, bpy.context.scene.hm.rotation_deg   # dragged
    window.key("ESC")
    yield
    assert abs(bpy.context.scene.hm.rotation_deg - 50) < 0.01, bpy.context.scene.hm.rotation_deg   # and left
    return item, photo


def edited(window, item):
    """A click picks the shirt; Ctrl Z takes the edit back, Shift Ctrl Z brings it again."""
    with window.override():
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.view3d.view_selected()
    yield
    yield
    x, y = on_screen(window, item, 0.5, 0.55)
    window.move(x, y)
    yield
    with window.override():
        bpy.ops.hm.edit_garment("INVOKE_DEFAULT")
    yield
    window.button("PRESS")
    yield
    window.button("RELEASE")
    yield from window.wait(lambda: any("." in key for key in edit.nodes_of(relief.material_of(
        bpy.context.view_layer.objects.active))), "the garment", 20)
    keys = [key for key in edit.nodes_of(relief.material_of(bpy.context.view_layer.objects.active)) if "." in key]
    assert keys and keys[0].startswith("fabric."), keys
    with window.override():
        bpy.ops.hm.apply_preset("EXEC_DEFAULT", True, class_name="fabric", garment=int(keys[0].partition(".")[2]),
                                preset="red")
    yield
    window.area.spaces.active.shading.type = "MATERIAL"
    yield from window.picture("2_red_shirt")


def steps(window, folder, sky):
    item, photo = yield from relit(window, folder, sky)
    yield from edited(window, item)
    scene = bpy.context.scene
    with window.override():
        bpy.ops.hm.set_plate("EXEC_DEFAULT", filepath=photo)
        bpy.ops.view3d.view_camera()
    yield from window.picture("3_plate")
    scene.hm.samples = 4
    with window.override():
        bpy.ops.hm.prepare_render("EXEC_DEFAULT", plain_view=True)
        bpy.ops.hm.render_picture("EXEC_DEFAULT", filepath=os.path.join(folder, "relit.png"))
    yield from window.wait(lambda: os.path.exists(os.path.join(folder, "relit.png")), "the picture", 600)
    with window.override():
        bpy.ops.hm.export_maps("EXEC_DEFAULT", directory=folder, folder_name="edited")
        bpy.ops.hm.export_glb("EXEC_DEFAULT", filepath=os.path.join(folder, "person.glb"))
    assert os.path.exists(os.path.join(folder, "edited", "maps.json"))
    assert os.path.getsize(os.path.join(folder, "person.glb")) > 10000
    with window.override():
        bpy.ops.hm.light_rig("EXEC_DEFAULT", kind="THREE_POINT")
    yield from window.picture("4_rig")


def main():
    folder, sky = driver.arguments()
    human_material.register()
    window = driver.Window(folder)
    driver.drive(steps(window, folder, sky), window)


main()
