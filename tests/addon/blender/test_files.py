"""What goes in and out: edited maps, GLB, File > Import, recent environments, a batch."""
import json
import os
import struct
import subprocess
import sys
import unittest.mock

import bpy
from support import ADDON, maps_folder, scene as s

from human_material.services import edit, edited, environment, maps, presets, programs, recent, relief, scan_object
from human_material.services.errors import InputError
from human_material.ui import files, thumbnails

PERSON = maps_folder.Person(24, 24)


class Files(s.Registered):
    def setUp(self):
        super().setUp()
        self.item, self.loaded = s.import_person(self.scene, PERSON)
        self.skin = relief.material_of(self.item)
        self.item.select_set(True)
        bpy.context.view_layer.objects.active = self.item
        self.folder = s.folder()

    def test_edited_maps_are_what_the_nodes_make(self):
        for class_name, preset in (("fabric", "red"), ("hair", "auburn"), ("fabric", "shiny_leather")):
            edit.apply(self.skin, class_name, presets.PRESETS[preset])
        found, _ = edited.rasters(self.skin)
        for meaning, name, factor in (("roughness", "roughness", 1), ("specular", "f0", 1 / 0.08)):
            s.show(self.item, s.source_of(s.socket_of(self.item, meaning)))
            shown = s.rendered(self.scene, 1, exact=True)
            for p in s.inside(self.loaded, 2):
                self.assertAlmostEqual(shown[3 * p], factor * found[name][p], delta=3e-3)
        s.show(self.item, s.source_of(s.socket_of(self.item, "base")))
        shown = s.rendered(self.scene, 1, exact=True)
        for p in s.inside(self.loaded, 2):
            for c in range(3):
                self.assertAlmostEqual(shown[3 * p + c], found["diffuse"][3 * p + c], delta=3e-3)

    def test_exported_maps_are_read_again(self):
        edit.apply(self.skin, "fabric", presets.PRESETS["red"])
        found, _ = edited.rasters(self.skin)
        bpy.ops.hm.export_maps(directory=self.folder, folder_name="edited")
        again = maps.load(os.path.join(self.folder, "edited"))
        self.assertEqual(sorted(os.listdir(self.folder)), ["edited"])
        for p in s.inside(self.loaded, 1):
            for mine, theirs, n in ((found["diffuse"], again.diffuse, 3), (found["roughness"], again.roughness, 1),
                                    (found["f0"], again.f0, 1), (self.loaded.displacement_cm, again.displacement_cm, 1)):
                for c in range(n):
                    self.assertAlmostEqual(mine[n * p + c], theirs[n * p + c], 5)
        with self.assertRaisesRegex(RuntimeError, "is there already"):
            bpy.ops.hm.export_maps(directory=self.folder, folder_name="edited")
        with self.assertRaisesRegex(RuntimeError, "cannot be written"):
            bpy.ops.hm.export_maps(directory=os.path.join(self.folder, "none"), folder_name="edited")

    def test_a_glb_holds_the_person(self):
        edit.apply(self.skin, "fabric", presets.PRESETS["red"])
        path = os.path.join(self.folder, "person.glb")
        bpy.ops.hm.export_glb(filepath=path)
        with open(path, "rb") as file:
            data = file.read()
        magic, version, total, size, kind = struct.unpack("<4sIII4s", data[:20])
        self.assertEqual((magic, version, total, kind), (b"glTF", 2, len(data), b"JSON"))
        document = json.loads(data[20:20 + size])
        self.assertEqual(document["accessors"][0]["count"], s.front_vertex_count(self.item))
        binary = data[28 + size:]
        view = document["bufferViews"][4]
        png = binary[view["byteOffset"]:view["byteOffset"] + view["byteLength"]]
        self.assertTrue(png.startswith(b"\x89PNG"))
        saved = os.path.join(self.folder, "base.png")
        with open(saved, "wb") as file:
            file.write(png)
        codes = maps.read_raster(saved, 3, 24, 24)
        found, _ = edited.rasters(self.skin)
        for p in s.inside(self.loaded, 1):
            for c in range(3):
                value = codes[3 * p + c]
                linear = value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4
                self.assertAlmostEqual(linear, found["diffuse"][3 * p + c], delta=6e-3)
        with self.assertRaisesRegex(RuntimeError, "is no .glb"):
            bpy.ops.hm.export_glb(filepath=os.path.join(self.folder, "person.obj"))

    def test_another_reader_takes_the_glb(self):
        try:
            program = programs.find("openhumanbrdf")
        except InputError as error:
            self.skipTest(str(error))
        path = os.path.join(self.folder, "person.glb")
        bpy.ops.hm.export_glb(filepath=path)
        done = subprocess.run([program, "inspect", path, "--unit", "m", "--json"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        triangles = sum(len(face.vertices) - 2 for face in s.front_faces(self.item))
        self.assertIn('"triangles": %d,' % triangles, done.stdout)

    def test_file_menus_have_entries(self):
        for menu in (bpy.types.TOPBAR_MT_file_import, bpy.types.TOPBAR_MT_file_export):
            self.assertIn(files.__name__, [f.__module__ for f in menu._dyn_ui_initialize()])
        self.assertEqual(bool(files.HANDLERS), hasattr(bpy.types, "FileHandler"))
        self.assertFalse(scan_object.is_scan(self.item))

    def test_files_dropped_on_the_view_are_opened(self):
        sky = os.path.join(self.folder, "sky.exr")
        maps_folder.environment(sky, (0, 0, 1), sky=1.0)
        bpy.ops.hm.set_environment("INVOKE_DEFAULT", filepath=sky)   # what a drop calls
        self.assertEqual(environment.path_of(self.scene), sky)
        if not files.HANDLERS:
            self.skipTest("this Blender has no file handlers")
        window = bpy.context.window_manager.windows[0]
        view, other = (next(a for a in window.screen.areas if (a.type == "VIEW_3D") == wanted) for wanted in (True, False))
        for area, takes in ((view, True), (other, False)):
            with bpy.context.temp_override(window=window, area=area):
                self.assertEqual({handler.poll_drop(bpy.context) for handler in files.HANDLERS}, {takes})
        drop = dict(directory=self.item["hm_maps"], files=[{"name": "maps.json"}])
        with bpy.context.temp_override(window=window, area=view, region=view.regions[-1]):
            self.assertEqual(bpy.ops.wm.drop_import_file("INVOKE_DEFAULT", **drop), {"FINISHED"})
        self.assertEqual(len(relief.reliefs(self.scene)), 2)
        for handler in files.HANDLERS:
            group, name = handler.bl_import_operator.split(".")
            properties = getattr(getattr(bpy.ops, group), name).get_rna_type().properties
            self.assertTrue(properties["filepath"].is_skip_save)   # else Blender refuses to drop on it

    def test_without_matching_the_camera_stays(self):
        camera, size = self.scene.camera, (self.scene.render.resolution_x, self.scene.render.resolution_y)
        self.scene.render.resolution_x = 77
        bpy.ops.hm.import_maps(filepath=os.path.join(self.item["hm_maps"], "maps.json"), match_camera=False)
        self.assertEqual((self.scene.camera, self.scene.render.resolution_x), (camera, 77))
        self.assertEqual(size[1], self.scene.render.resolution_y)

    def test_environments_used_last_come_first(self):
        file = os.path.join(self.folder, "a", "recent.json")
        paths = [os.path.join(self.folder, "%d.exr" % k) for k in range(15)]
        for path in paths:
            open(path, "w", encoding="ascii").close()
            recent.add(file, path)
        recent.add(file, paths[10])
        os.remove(paths[14])
        found = recent.read(file)
        self.assertEqual((found[:2], len(found)), ([paths[10], paths[13]], recent.MOST - 1))
        recent.add("/proc/none/recent.json", paths[0])   # no matter
        with open(file, "w", encoding="ascii") as stream:
            stream.write("{")
        self.assertEqual(recent.read(file), [])
        self.assertEqual(len(recent.of_folder(self.folder)), 14)
        self.assertTrue(thumbnails.items(None, None))

    def test_a_small_picture_lights_the_scene(self):
        paths = [os.path.join(self.folder, name) for name in ("a.exr", "b.exr")]
        for path in paths:
            maps_folder.environment(path, (0, 0, 1), sky=1.0)
        with unittest.mock.patch.object(thumbnails, "file", lambda: os.path.join(self.folder, "recent.json")):
            for path in paths:
                bpy.ops.hm.set_environment(filepath=path)
                self.assertEqual(self.scene.hm.environment_file, path)
            self.scene.hm.environment_file = paths[0]   # what a click on the small picture does
            self.assertEqual(environment.path_of(self.scene), paths[0])
            self.assertEqual(thumbnails.paths()[:2], paths)

    def test_a_batch_leaves_out_what_is_wrong_and_goes_on(self):
        sky = os.path.join(self.folder, "sky.exr")
        maps_folder.environment(sky, (0, 0, 1), sky=1.0)
        output = os.path.join(self.folder, "out")
        script = os.path.join(ADDON, "relight_batch.py")
        command = ([bpy.app.binary_path, "-b", "-noaudio", "--factory-startup", "--python", script, "--"]
                   if bpy.app.binary_path else [sys.executable, script])
        command += [self.item["hm_maps"], self.folder, "--environment", sky, "--rotation", "0,90", "--spp", "1", "-o",
                    output]
        done = subprocess.run(command, capture_output=True, text=True, timeout=300)
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertEqual(sorted(os.listdir(output)), ["person_sky_0.png", "person_sky_90.png"])
        self.assertIn("left out", done.stderr)
        self.assertIn("there is no such file", done.stderr)
