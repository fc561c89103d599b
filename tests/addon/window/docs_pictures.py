"""Makes the pictures of docs/blender anew, by hand, from the bundled person (needs oiiotool, ImageMagick and xvfb):

    HM_TOOLS=build/release/bin python3 tests/addon/window_test.py blender FOLDER docs_pictures.py \\
        $PWD/assets/example_human/example_human.glb $PWD/assets/example_human/example_human.labels.txt \\
        $PWD/assets/environments/studio.exr
    cp FOLDER/docs/*.png docs/blender/
"""
import os
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.dirname(HERE)]

import bpy  # noqa: E402
import driver  # noqa: E402
import tool_steps  # noqa: E402
from support import ADDON  # noqa: E402

import human_material  # noqa: E402
from human_material.services import garment_edit, label_session, programs, relief  # noqa: E402

sys.path.insert(0, os.path.join(ADDON, "tools"))
import sample_to_maps  # noqa: E402

CROP, WIDTH_PX, COLORS = "800x680+250+24", 600, 40


def kept(window, name):
    """The 3D view's right part, small enough for a page; without the paths of this machine."""
    settings = bpy.context.scene.hm.tools
    paths = {p.identifier: getattr(settings, p.identifier) for p in settings.bl_rna.properties
             if p.type == "STRING" and not p.is_readonly}
    for field, path in paths.items():
        setattr(settings, field, os.path.basename(path.rstrip(os.sep)))
    yield from window.picture(name)
    for field, path in paths.items():
        setattr(settings, field, path)
    folder = os.path.join(window.folder, "docs")
    os.makedirs(folder, exist_ok=True)
    subprocess.run(["convert", os.path.join(window.folder, name + ".png"), "-crop", CROP, "+repage", "-resize",
                    "%dx" % WIDTH_PX, "+dither", "-colors", str(COLORS), "-define", "png:compression-level=9",
                    os.path.join(folder, name + ".png")], check=True)


def fronted(window, view="FRONT"):
    with window.override():
        bpy.ops.view3d.view_axis(type=view)
        bpy.ops.view3d.view_selected()
    yield


def labelled(window, scan):
    window.show_panels("HM_PT_label")
    with window.override():
        bpy.ops.hm.open_scan("EXEC_DEFAULT", filepath=scan)
    yield from window.wait(lambda: bpy.context.view_layer.objects.active is not None, "the scan")
    session = label_session.of(bpy.context.view_layer.objects.active)
    yield from window.wait(session.is_settled, "the first answer")
    yield from fronted(window)
    yield from kept(window, "label")
    label_session.close_all()
    bpy.data.objects.remove(bpy.context.view_layer.objects.active)


def tools(window):
    settings = bpy.context.scene.hm.tools
    window.show_panels("HM_PT_bake")
    settings.size_px = 1024
    yield from tool_steps.run(window, "bake", "bake")
    with window.override():
        bpy.ops.hm.show_model()
    window.area.spaces.active.shading.color_type = "TEXTURE"
    yield from fronted(window)
    yield from kept(window, "bake")
    window.show_panels("HM_PT_produce")
    yield from tool_steps.run(window, "produce", "produce")
    yield from tool_steps.run(window, "show_samples", "produce")
    yield from kept(window, "produce")
    window.show_panels("HM_PT_validate")
    settings.view_px, settings.spp, settings.seeds = 24, 4, 2
    yield from tool_steps.run(window, "validate", "validate")
    yield from kept(window, "validate")
    bpy.data.objects.remove(bpy.context.view_layer.objects.active)


def maps_of(folder, model, light):
    samples, maps = os.path.join(folder, "samples"), os.path.join(folder, "maps")
    subprocess.run([programs.find("openhumanbrdf"), "render", model, "--environment", light, "--size", "512", "--spp",
                    "1", "-o", samples], check=True, capture_output=True)
    sample_to_maps.convert(os.path.join(samples, "view_000.exr"), maps)
    return maps


def relit(window, folder, light):
    maps = maps_of(folder, bpy.context.scene.hm.tools.model, light)
    window.area.spaces.active.shading.type = "MATERIAL"
    with window.override():
        bpy.ops.hm.import_maps("EXEC_DEFAULT", filepath=os.path.join(maps, "maps.json"))
    item = bpy.context.view_layer.objects.active
    bpy.context.scene.camera.hide_set(True)     # it stands before the person
    for name, panels in (("maps", ["HM_PT_maps"]), ("render", ["HM_PT_render"]), ("export", ["HM_PT_export"])):
        window.show_panels(*panels)
        yield from fronted(window)
        yield from kept(window, name)
    window.show_panels("HM_PT_light")
    with window.override():
        bpy.ops.hm.set_environment("EXEC_DEFAULT", filepath=light)
    shading = window.area.spaces.active.shading
    shading.use_scene_world, shading.use_scene_lights = True, True
    bpy.context.scene.hm.rotation_deg = 60
    yield from kept(window, "light")
    window.show_panels("HM_PT_edit", "HM_PT_edit_fabric")
    skin = relief.material_of(item)
    number = next(n for n, class_name, _ in garment_edit.all_of(skin) if class_name == "fabric")
    with window.override():
        garment_edit.node_for(skin, number)
        bpy.ops.hm.apply_preset("EXEC_DEFAULT", class_name="fabric", garment=number, preset="red")
    yield from kept(window, "edit")
    window.show_panels("HM_PT_studio")
    with window.override():
        bpy.ops.hm.add_ground("EXEC_DEFAULT")
        bpy.ops.hm.light_rig("EXEC_DEFAULT", kind="THREE_POINT")
    for light in [o for o in bpy.data.objects if o.type == "LIGHT"]:
        light.hide_set(True)
    shading.use_scene_world = False
    bpy.context.view_layer.objects.active = item
    item.select_set(True)
    yield from fronted(window)
    yield from kept(window, "studio")


def steps(window, folder, scan, labels, light):
    for item in list(bpy.data.objects):
        bpy.data.objects.remove(item)
    window.area.spaces.active.show_region_ui = True
    tool_steps.prepared(folder, scan, labels, light)
    window.show_panels("HM_PT_label")
    yield
    yield from window.click_window(1044, 272)   # the tab Human Material
    yield from labelled(window, scan)
    yield from tools(window)
    yield from relit(window, folder, light)


def main():
    folder, *rest = driver.arguments()
    human_material.register()
    window = driver.Window(folder)
    bpy.context.preferences.system.viewport_aa = "8"
    driver.drive(steps(window, folder, *rest), window)


main()
