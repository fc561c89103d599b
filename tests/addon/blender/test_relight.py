"""relight.py as `humanmaterial relight` calls it: pictures, exit codes, one line of words."""
import json
import os
import subprocess
import sys
import unittest

import bpy
from support import ADDON, maps_folder, scene as s

from human_material.services.maps import read_raster

SCRIPT = os.path.join(ADDON, "relight.py")


def relight(*arguments):
    if bpy.app.binary_path:
        command = [bpy.app.binary_path, "-b", "-noaudio", "--factory-startup", "--python-exit-code", "1",
                   "--python", SCRIPT, "--"]
    else:
        command = [sys.executable, SCRIPT]
    return subprocess.run([*command, *arguments], capture_output=True, text=True, timeout=300)


class Relight(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = s.folder()
        cls.maps = os.path.join(cls.folder, "person")
        maps_folder.write(cls.maps, maps_folder.Person(24, 16, maps_folder.ORTHOGRAPHIC))
        cls.sky = os.path.join(cls.folder, "sky.exr")
        maps_folder.environment(cls.sky, (0, 0, 1), sky=1.0)

    def test_picture_and_report(self):
        picture, report = os.path.join(self.folder, "a.exr"), os.path.join(self.folder, "a.json")
        done = relight(self.maps, "--environment", self.sky, "--rotation", "30", "--point", "0,200,200,2",
                       "--edit", "fabric:shiny_leather", "--edit", "hair:#803020", "--size", "48", "--spp", "2",
                       "--report", report, "-o", picture)
        self.assertEqual(done.returncode, 0, done.stderr + done.stdout)
        with open(report, encoding="utf-8") as file:
            self.assertEqual(json.load(file)["size_px"], [48, 32])
        values = read_raster(picture, 3, 48, 32)
        self.assertGreater(values[3 * (16 * 48 + 20)], 0)
        self.assertEqual([n for n in os.listdir(self.folder) if "part" in n], [])

    def test_bad_input_is_one_line_and_exit_2(self):
        picture = os.path.join(self.folder, "none.png")
        for arguments, words in (((self.maps, "-o", picture), "there is no light"),
                                 ((os.path.join(self.folder, "sky.exr"), "--environment", self.sky, "-o", picture),
                                  "is not JSON")):
            done = relight(*arguments)
            self.assertEqual(done.returncode, 2, done.stderr)
            lines = [line for line in done.stderr.splitlines() if line.startswith("relight: ")]
            self.assertEqual(len(lines), 1, done.stderr)
            self.assertIn(words, lines[0])
            self.assertFalse(os.path.exists(picture))
