"""The add-on as a guest in the user's scene: what it must not touch, and what it must say."""
import math
import os

import bpy
from support import maps_folder, scene as s

from human_material import compat
from human_material.services import edit, environment, material, presets, relief, watch

PERSON = maps_folder.Person(16, 16)


class Guest(s.Registered):
    def imported(self, changed=None):
        folder = os.path.join(s.folder(), "person")
        maps_folder.write(folder, PERSON, changed)
        bpy.ops.hm.import_maps(filepath=os.path.join(folder, "maps.json"))
        return bpy.context.object

    def lit(self):
        path = os.path.join(s.folder(), "sky.exr")
        maps_folder.environment(path, (0, 0, 1), sky=0.2)
        bpy.ops.hm.set_environment(filepath=path)
        return path

    def evaluated(self, owner):
        return owner.evaluated_get(bpy.context.evaluated_depsgraph_get())

    def test_keyframes_on_settings_work(self):
        item = self.imported()
        self.lit()
        settings = self.scene.hm
        for frame, values in ((1, (0, 1, 1)), (11, (90, 3, 0))):
            settings.rotation_deg, settings.strength, settings.subsurface_scale = values
            for name in ("rotation_deg", "strength", "subsurface_scale"):
                settings.keyframe_insert(name, frame=frame)
        for frame, values in ((1, (0, 1, 1)), (11, (90, 3, 0)), (1, (0, 1, 1))):
            self.scene.frame_set(frame)
            nodes = self.evaluated(self.scene.world).node_tree.nodes
            skin = self.evaluated(relief.material_of(item)).node_tree.nodes
            found = (-math.degrees(nodes[environment.MAPPING].inputs["Rotation"].default_value[2]),
                     nodes[environment.BACKGROUND].inputs["Strength"].default_value,
                     skin[material.SUBSURFACE_SCALE].inputs[1].default_value)
            for value, wanted in zip(found, values):
                self.assertAlmostEqual(value, wanted, places=3)

    def test_moving_a_value_raises_its_amount(self):
        skin = relief.material_of(self.imported())
        bpy.context.view_layer.update()
        for value, amount in watch.AMOUNT_OF.items():
            node = edit.node_of(skin, "fabric")
            node.inputs[value].default_value = (0.1, 0.2, 0.3, 1) if value == "Color" else 0.11
            bpy.context.view_layer.update()
            self.assertEqual(node.inputs[amount].default_value, 1, value)
            node.inputs[amount].default_value = 0   # by hand: stays
            bpy.context.view_layer.update()
            self.assertEqual(node.inputs[amount].default_value, 0, value)
        bpy.ops.hm.apply_preset(class_name="hair", preset="red")
        bpy.context.view_layer.update()
        bpy.ops.hm.reset_edit(class_name="hair")
        bpy.context.view_layer.update()
        self.assertEqual(edit.node_of(skin, "hair").inputs["Color Amount"].default_value, 0)

    def test_prepare_render_keeps_what_it_was_not_told_to_change(self):
        self.imported()
        self.scene.render.engine = "BLENDER_EEVEE" if hasattr(bpy.types, "SceneEEVEE") and \
            compat.generation() == "principled_v1" else "CYCLES"
        compat.set_compositor(self.scene, True)
        self.scene.view_settings.view_transform = "Filmic"
        self.scene.cycles.use_denoising = compat.can_denoise()
        before = compat.render_state(self.scene)
        self.scene.hm.samples = 77
        bpy.ops.hm.prepare_render()
        after = compat.render_state(self.scene)
        for name in ("device", "denoiser", "view", "look", "exposure", "gamma", "compositor"):
            self.assertEqual(after[name], before[name], name)
        self.assertEqual((after["engine"], after["samples"]), ("CYCLES", 77))
        bpy.ops.hm.prepare_render(plain_view=True, no_compositor=True)
        self.assertEqual(compat.render_state(self.scene)["view"], "Standard")
        self.assertFalse(compat.has_compositor(self.scene))

    def test_render_picture_asks_and_leaves_the_output_settings(self):
        self.imported()
        image = self.scene.render.image_settings
        image.file_format, image.color_mode, image.color_depth = "PNG", "RGB", "8"
        self.scene.hm.samples = 1
        bpy.ops.hm.prepare_render()
        self.scene.render.filepath = "//mine"
        path = os.path.join(s.folder(), "picture.exr")
        bpy.ops.hm.render_picture(filepath=path)
        self.assertEqual((image.file_format, image.color_mode, image.color_depth, self.scene.render.filepath),
                         ("PNG", "RGB", "8", "//mine"))
        with open(path, "wb") as file:
            file.write(b"mine")
        with self.assertRaises(RuntimeError) as caught:
            bpy.ops.hm.render_picture(filepath=path)
        self.assertIn("there already", str(caught.exception))
        self.assertEqual(os.path.getsize(path), 4)
        bpy.ops.hm.render_picture(filepath=path, overwrite=True)
        self.assertGreater(os.path.getsize(path), 100)

    def test_a_second_person_stands_beside_the_first(self):
        first, second = self.imported(), self.imported()
        bpy.context.view_layer.update()
        sides = [[(item.matrix_world @ vertex.co).x for vertex in item.data.vertices] for item in (first, second)]
        self.assertGreater(min(sides[1]), max(sides[0]))
        second.location.y += 1
        second.rotation_euler.z = 0.5
        bpy.ops.hm.match_camera()
        bpy.context.view_layer.update()
        seen = self.scene.camera.matrix_world.inverted() @ second.matrix_world
        for found, wanted in zip(seen.to_translation(), (0, 0, -4)):
            self.assertAlmostEqual(found, wanted, places=4)
        self.assertLess(seen.to_quaternion().angle, 1e-3)

    def test_a_copy_has_its_own_material(self):
        item = self.imported()
        bpy.ops.object.duplicate()
        bpy.context.view_layer.update()
        copy = bpy.context.object
        self.assertIsNot(copy, item)
        self.assertIsNot(relief.material_of(copy), relief.material_of(item))
        edit.apply(relief.material_of(copy), "hair", presets.PRESETS["red"])
        self.assertEqual(edit.node_of(relief.material_of(item), "hair").inputs["Color Amount"].default_value, 0)

    def test_a_missing_environment_is_said(self):
        self.imported()
        os.remove(self.lit())
        with self.assertRaises(RuntimeError) as caught:
            bpy.ops.hm.render_picture(filepath=os.path.join(s.folder(), "a.png"))
        self.assertIn("not there any more", str(caught.exception))

    def test_the_default_cube_is_hidden(self):
        cube = bpy.data.objects.new("Cube", bpy.data.meshes.new("Cube"))
        cube.data.from_pydata([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], [], [])
        self.scene.collection.objects.link(cube)
        bpy.context.view_layer.update()
        self.imported()
        self.assertTrue(cube.hide_render and cube.hide_get())

    def test_samples_of_viewport_and_picture(self):
        self.imported()
        bpy.ops.hm.prepare_render()
        self.scene.hm.samples, self.scene.hm.preview_samples = 99, 7
        self.assertEqual((self.scene.cycles.samples, self.scene.cycles.preview_samples), (99, 7))

    def test_presets_by_class(self):
        for class_name, named, other in (("hair", "blond", "shiny_leather"), ("fabric", "shiny_leather", "blond"),
                                         ("skin", "tan_skin", "red")):
            names = [preset.name for preset in presets.of_class(class_name)]
            self.assertIn(named, names)
            self.assertNotIn(other, names)

    def test_directx_normals_are_found(self):
        """A ball's normals with the green channel down; and those of the ball itself are taken."""
        person = maps_folder.Person(32, 32, maps_folder.ORTHOGRAPHIC)
        person.normal = lambda x, y: tuple(c / math.sqrt(1 + 0.36 * sum(v * v for v in person.place(x, y)))
                                           for c in (*(0.6 * v for v in person.place(x, y)), 1.0))
        folder = os.path.join(s.folder(), "person")
        down = person.raster(lambda x, y: (person.normal(x, y)[0], -person.normal(x, y)[1], person.normal(x, y)[2]))
        maps_folder.write(folder, person, {"normal": down})
        with self.assertRaises(RuntimeError) as caught:
            bpy.ops.hm.import_maps(filepath=os.path.join(folder, "maps.json"))
        self.assertIn("DirectX", str(caught.exception))
        maps_folder.write(folder, person)
        self.assertEqual(bpy.ops.hm.import_maps(filepath=os.path.join(folder, "maps.json")), {"FINISHED"})
