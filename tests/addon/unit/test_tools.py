"""The tools that make maps folders."""
import os
import subprocess
import sys
import unittest

from support import ADDON, image_files, maps_folder, temporary_folder

from human_material.services import maps_json

sys.path.insert(0, os.path.join(ADDON, "tools"))
import sample_to_maps  # noqa: E402
import write_maps_json  # noqa: E402


def run(tool, *arguments):
    return subprocess.run([sys.executable, os.path.join(ADDON, "tools", tool), *arguments], capture_output=True,
                          text=True)


class WriteMapsJson(unittest.TestCase):
    def setUp(self):
        self.folder = temporary_folder(self)
        person = maps_folder.Person(16, 12, maps_folder.ORTHOGRAPHIC)
        maps_folder.write_png(self.folder, person)
        os.remove(os.path.join(self.folder, "maps.json"))
        for name, other in (("normal", "portrait_N"), ("diffuse", "portrait_albedo_01")):
            os.rename(os.path.join(self.folder, name + ".png"), os.path.join(self.folder, other + ".png"))

    def test_finds_maps_by_their_names(self):
        done = run("write_maps_json.py", self.folder, "--orthographic", "160", "--center-y", "80")
        self.assertEqual(done.returncode, 0, done.stderr)
        info = maps_json.read(self.folder)
        self.assertEqual((info.width_px, info.height_px, info.camera.center_y_cm), (16, 12, 80))
        self.assertEqual(info.maps["diffuse"].encoding, "srgb")
        self.assertEqual(os.path.basename(info.maps["normal"].path), "portrait_N.png")
        self.assertEqual(info.maps["displacement"].r_cm, 80)

    def test_missing_and_ambiguous_files_are_named(self):
        image_files.png(os.path.join(self.folder, "other_sss.png"), 16, 12, [0] * 192)
        done = run("write_maps_json.py", self.folder, "--perspective", "400", "0.2")
        self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1))
        self.assertIn("both other_sss.png and sss.png", done.stderr)
        for name in ("other_sss.png", "sss.png", "roughness.png"):
            os.remove(os.path.join(self.folder, name))
        done = run("write_maps_json.py", self.folder, "--perspective", "400", "0.2")
        self.assertEqual(done.returncode, 2)
        self.assertIn("roughness, sss", done.stderr)
        self.assertFalse(os.path.exists(os.path.join(self.folder, "maps.json")))


class SampleToMaps(unittest.TestCase):
    def test_camera_of_the_attributes(self):
        camera = sample_to_maps.camera_of({"ohb:cameraDistance_cm": "438.5", "ohb:cameraHalfWidth": "0.2117647",
                                           "ohb:cameraCenterY_cm": "84.5"}, "s.exr")
        self.assertEqual(camera, maps_json.Camera("perspective", 438.5, 0.2117647, 0, 84.5))
        self.assertRaises(sample_to_maps.InputError, sample_to_maps.camera_of, {}, "s.exr")

    def test_bad_input_is_one_line(self):
        for path in ("/nowhere.exr", __file__):
            done = run("sample_to_maps.py", path, "-o", temporary_folder(self))
            self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1), done.stderr)
