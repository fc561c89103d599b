"""Photograph behind the person, shadow on the ground, rigs of lights, videos."""
import math
import os
import unittest.mock

import bpy
from mathutils import Vector
from support import image_files, maps_folder, scene as s

from human_material import compat
from human_material.services import plate, render, rigs, turntable
from human_material.services.maps import read_raster

PERSON = maps_folder.Person(24, 24)
BLUE = (30, 60, 220)


class Studio(s.Registered):
    def setUp(self):
        super().setUp()
        self.item, self.loaded = s.import_person(self.scene, PERSON)
        self.item.select_set(True)
        bpy.context.view_layer.objects.active = self.item
        self.folder = s.folder()
        self.photo = os.path.join(self.folder, "photo.png")
        image_files.png(self.photo, 48, 48, list(BLUE) * (48 * 48), 3, 8)
        s.light_up(self.scene, (0, 0, 1), sky=0.5)

    def picture(self):
        """RGB as written, through the compositor."""
        path = os.path.join(self.folder, "out.exr")
        render.to_file(self.scene, path)
        return read_raster(path, 3, self.scene.render.resolution_x, self.scene.render.resolution_y)

    def prepare(self):
        render.prepare_scene(self.scene, 4, 4, plain_view=True)
        self.scene.cycles.seed = 0
        self.scene.render.film_transparent = True

    def test_the_photograph_is_around_the_person(self):
        self.prepare()
        alone = self.picture()
        bpy.ops.hm.set_plate(filepath=self.photo)
        self.assertTrue(self.scene.camera.data.show_background_images)
        over = self.picture()
        wanted = [((code / 255 + 0.055) / 1.055) ** 2.4 for code in BLUE]
        for c in range(3):
            self.assertAlmostEqual(over[c], wanted[c], delta=2e-3)   # a corner
        middle = 3 * (12 * 24 + 12)
        for c in range(3):
            self.assertAlmostEqual(over[middle + c], alone[middle + c], delta=1e-4)
        bpy.ops.hm.set_plate(filepath=self.photo)   # again: still one
        self.assertEqual(len(self.scene.camera.data.background_images), 1)
        bpy.ops.hm.remove_plate()
        again = self.picture()
        self.assertLess(max(abs(a - b) for a, b in zip(alone, again)), 1e-5)
        self.assertEqual(len(self.scene.camera.data.background_images), 0)

    def test_other_nodes_of_the_compositor_stay(self):
        self.prepare()
        compat.set_compositor(self.scene, True)
        tree, end = compat.compositor(self.scene)
        layers = tree.nodes.new("CompositorNodeRLayers")
        own = tree.nodes.new("CompositorNodeInvert")
        tree.links.new(layers.outputs[0], own.inputs["Color"])
        tree.links.new(own.outputs[0], end)
        count = len(tree.nodes)
        bpy.ops.hm.set_plate(filepath=self.photo)
        bpy.ops.hm.remove_plate()
        self.assertEqual(len(tree.nodes), count)
        self.assertEqual(end.links[0].from_node, own)

    def test_wrong_photographs_change_nothing(self):
        wide = os.path.join(self.folder, "wide.png")
        image_files.png(wide, 20, 10, [0] * 600, 3, 8)
        before = s.data_counts(), compat.has_compositor(self.scene)
        for path, words in ((wide, "is 20 x 10, the scene's picture 24 x 24"), (self.folder + "/none.png", "no such")):
            with self.assertRaisesRegex(RuntimeError, words):
                bpy.ops.hm.set_plate(filepath=path)
        self.scene.camera = None
        with self.assertRaisesRegex(RuntimeError, "Match Camera first"):
            bpy.ops.hm.set_plate(filepath=self.photo)
        self.assertEqual((s.data_counts(), compat.has_compositor(self.scene)), before)

    def test_the_ground_is_its_shadow_alone(self):
        self.prepare()
        self.scene.render.film_transparent = True
        bpy.ops.hm.add_ground()
        bpy.ops.hm.add_ground()
        grounds = [o for o in self.scene.objects if plate.CATCHER in o]
        self.assertEqual(len(grounds), 1)
        self.assertTrue(grounds[0].is_shadow_catcher)
        lowest = min((self.item.matrix_world @ v.co).z for v in self.item.data.vertices)
        self.assertAlmostEqual(grounds[0].location.z, 0 if abs(lowest) < 0.05 else lowest, 4)

    def test_three_point_light_comes_from_where_it_says(self):
        bpy.ops.hm.light_rig(kind="THREE_POINT")
        self.assertEqual(self.scene.hm.strength, 0)
        key, fill, rim = (next(o for o in self.scene.objects if o.get(rigs.RIG) == name)
                          for name in ("Key", "Fill", "Rim"))
        middle = self.item.location
        self.assertLess(key.location.x, middle.x)    # the picture's left, before, above
        self.assertLess(key.location.y, middle.y)
        self.assertGreater(key.location.z, middle.z)
        self.assertGreater(rim.location.y, middle.y)
        for light in (key, fill, rim):   # each looks at the person
            forward = light.matrix_world.to_quaternion() @ Vector((0, 0, -1))
            away = middle - light.location
            self.assertGreater(forward.dot(away.normalized()), 0.999)
        bpy.ops.hm.light_rig(kind="THREE_POINT")
        self.assertEqual(bpy.ops.hm.remove_rig(), {"FINISHED"})
        self.assertFalse([o for o in self.scene.objects if o.type == "LIGHT"])

    def test_the_key_light_has_the_irradiance_it_says(self):
        flat, _ = s.import_person(self.scene, maps_folder.Person(24, 24, maps_folder.ORTHOGRAPHIC, flat=True))
        made = rigs.three_point(self.scene, flat)
        width = rigs.frame_of(flat)[1]
        light = made[0]
        distance = (light.location - flat.matrix_world.translation).length
        self.assertAlmostEqual(distance, rigs.AREA_AWAY * width, 4)
        self.assertAlmostEqual(light.data.energy / math.pi / distance ** 2, rigs.THREE_POINT["Key"][2], 4)

    def test_the_papers_lights_one_a_frame(self):
        bpy.ops.hm.light_rig(kind="PAPER_FRAMES")
        mine = [o for o in self.scene.objects if rigs.RIG in o]
        self.assertEqual((len(mine), self.scene.frame_end), (37, 37))
        for frame in (1, 17, 37):
            self.scene.frame_set(frame)
            self.assertEqual([o[rigs.RIG] for o in mine if not o.hide_render], [str(frame)])
        back = self.item.matrix_world.to_quaternion().inverted()
        first = back @ (mine[0].location - self.item.matrix_world.translation)
        self.assertAlmostEqual(math.degrees(math.atan2(first.z, first.x)), 5, 3)
        self.assertAlmostEqual(first.y, 0, 5)
        self.assertAlmostEqual(first.length, rigs.frame_of(self.item)[1], 4)   # 2 of the loss's units, half a frame each
        bpy.ops.hm.light_rig(kind="PAPER")
        mine = [o for o in self.scene.objects if rigs.RIG in o]
        self.assertTrue(all(not o.hide_render for o in mine))
        self.assertFalse([a for a in bpy.data.actions if a.name.startswith(rigs.NAME)])

    def test_the_light_goes_once_around(self):
        bpy.ops.hm.turntable(what="LIGHT", frames=8)
        turned = []
        for frame in (1, 3, 5, 8):
            self.scene.frame_set(frame)
            bpy.context.view_layer.update()
            turned.append(self.scene.hm.rotation_deg)
        for found, wanted in zip(turned, (0, 90, 180, 315)):
            self.assertAlmostEqual(found, wanted, 3)

    def test_the_camera_swings_and_comes_back(self):
        bpy.ops.hm.turntable(what="CAMERA", frames=8, angle_deg=20)
        camera, middle = self.scene.camera, self.item.location
        angles = []
        for frame in (1, 3, 5, 7):
            self.scene.frame_set(frame)
            away = camera.matrix_world.translation - middle
            angles.append(math.degrees(math.atan2(away.x, -away.y)))
        for found, wanted in zip(angles, (0, 20, 0, -20)):
            self.assertAlmostEqual(found, wanted, 2)

    def test_a_video_is_written_and_settings_stay(self):
        self.prepare()
        self.scene.frame_end = 3
        before = render.output_state(self.scene)
        path = os.path.join(self.folder, "a.mp4")
        bpy.ops.hm.render_video(filepath=path)
        self.assertGreater(os.path.getsize(path), 200)
        self.assertEqual(render.output_state(self.scene), before)
        self.assertEqual([n for n in os.listdir(self.folder) if "part" in n], [])
    def play(self, path, handler):
        """A render in a window that writes something and ends by a handler; gives the words, as the timer says them."""
        said, later = [], []
        def rendered(*_, **how):
            self.assertTrue(how["animation"])
            with open(self.scene.render.filepath, "wb") as file:
                file.write(b"video")
            for function in list(getattr(bpy.app.handlers, handler)):
                function(self.scene)
        with unittest.mock.patch.object(render.bpy, "ops") as ops, \
                unittest.mock.patch.object(render.bpy.app.timers, "register", lambda f, **_: later.append(f)):
            ops.render.render.side_effect = rendered
            turntable.in_window(self.scene, path, said.append)
        for function in later:
            function()
        return said

    def test_a_video_in_a_window_is_there_when_it_is_whole(self):
        self.prepare()
        before, counts = render.output_state(self.scene), len(bpy.app.handlers.render_complete)
        path = os.path.join(self.folder, "a.mp4")
        self.assertEqual(self.play(path, "render_complete"), ["Wrote %s" % path])
        stopped = os.path.join(self.folder, "b.mp4")   # Esc
        self.assertEqual(self.play(stopped, "render_cancel"), ["b.mp4 was not written: stopped"])
        self.assertEqual([n for n in os.listdir(self.folder) if n.endswith("mp4")], ["a.mp4"])
        self.assertEqual(render.output_state(self.scene), before)
        self.assertEqual(len(bpy.app.handlers.render_complete), counts)

    def test_videos_that_cannot_be(self):
        for wrong, words in (("a.avi", "is no video"), ("none/a.mp4", "is no folder")):
            with self.assertRaisesRegex(RuntimeError, words):
                bpy.ops.hm.render_video(filepath=os.path.join(self.folder, wrong))
