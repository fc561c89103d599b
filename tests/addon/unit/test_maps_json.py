"""maps.json: what is read, and every way in which it can be wrong."""
import copy
import json
import math
import os
import unittest

from support import maps_folder, temporary_folder

from human_material.services import maps_json
from human_material.services.errors import InputError

REMOVE = object()

#: (path of keys, value or REMOVE, words of the message)
WRONG = (
    (["format"], "other", "format"),
    (["version"], 2, "version"),
    (["version"], True, "version"),
    (["version"], REMOVE, "version"),
    (["unit"], "m", "unit"),
    (["size_px"], [16], "size_px"),
    (["size_px"], [16, 16.5], "size_px"),
    (["size_px"], [100000, 16], "size_px"),
    (["size_px"], [-16, 16], "size_px"),
    (["camera"], REMOVE, "camera"),
    (["camera", "type"], "fisheye", "camera.type"),
    (["camera", "distance_cm"], 0, "camera.distance_cm"),
    (["camera", "distance_cm"], "400", "camera.distance_cm"),
    (["camera", "half_width"], -1, "camera.half_width"),
    (["camera", "half_width"], math.nan, "camera.half_width"),
    (["camera", "half_width"], 10 ** 400, "camera.half_width"),
    (["camera", "center_y_cm"], [], "camera.center_y_cm"),
    (["maps"], [], "maps"),
    (["maps", "sss"], REMOVE, "'sss'"),
    (["maps", "sss"], "sss.exr", "maps.sss"),
    (["maps", "specular", "encoding"], "guess", "srgb_f0 or disney08 or linear_f0"),
    (["maps", "specular", "encoding"], REMOVE, "maps.specular.encoding"),
    (["maps", "specular", "encoding"], ["srgb_f0"], "maps.specular.encoding"),
    (["maps", "normal", "file"], "../normal.exr", "outside"),
    (["maps", "normal", "file"], "/etc/passwd", "outside"),
    (["maps", "normal", "file"], "nowhere.exr", "no such file"),
    (["maps", "normal", "file"], "", "file name"),
    (["maps", "normal", "file"], "a\0b", "file name"),
    (["maps", "displacement", "encoding"], "offset", "r_cm"),
)


class MapsJson(unittest.TestCase):
    def setUp(self):
        self.folder = temporary_folder(self)
        self.content = maps_folder.write(self.folder, maps_folder.Person(16, 16))

    def refuse(self, words):
        with self.assertRaises(InputError) as caught:
            maps_json.read(self.folder)
        self.assertIn(words, str(caught.exception))
        self.assertNotIn("\n", str(caught.exception))

    def put(self, data):
        with open(os.path.join(self.folder, "maps.json"), "wb") as file:
            file.write(data)

    def test_reads_folder_and_file(self):
        for path in (self.folder, os.path.join(self.folder, "maps.json")):
            info = maps_json.read(path)
            self.assertEqual((info.width_px, info.height_px), (16, 16))
            self.assertEqual(info.camera.distance_cm, 400)
            self.assertAlmostEqual(info.camera.frame_width_cm, 160)
            self.assertEqual(len(info.maps), 7)
            self.assertEqual(info.maps["normal"].encoding, "signed")

    def test_every_wrong_value_is_named(self):
        for keys, value, words in WRONG:
            with self.subTest(keys=keys, value=str(value)[:20]):
                content = copy.deepcopy(self.content)
                owner = content
                for key in keys[:-1]:
                    owner = owner[key]
                if value is REMOVE:
                    del owner[keys[-1]]
                else:
                    owner[keys[-1]] = value
                maps_folder.write_json(self.folder, content)
                self.refuse(words)

    def test_no_json_at_all(self):
        whole = json.dumps(self.content).encode()
        for data in (b"", whole[:-20], b"[]", b"\xff\xfe\x00", b"null", b'{"a":' * 100000):
            with self.subTest(data=data[:10]):
                self.put(data)
                self.refuse("maps.json")
        self.put(b" " * (maps_json.MAX_BYTES + 1))
        self.refuse("1 MiB")
        os.remove(os.path.join(self.folder, "maps.json"))
        self.refuse("no such file")

    def test_unknown_keys_are_ignored(self):
        self.content["later"] = {"deep": [1]}
        self.content["maps"]["sss"]["later"] = 1
        maps_folder.write_json(self.folder, self.content)
        maps_json.read(self.folder)

    def test_what_is_written_is_read_again(self):
        camera = maps_json.Camera("perspective", 431.25, 0.2117647, center_y_cm=85.5)
        maps_json.write(self.folder, maps_json.document((16, 16), camera, self.content["maps"], {"who": "test"}))
        info = maps_json.read(self.folder)
        self.assertEqual(info.camera, camera)
        self.assertEqual(os.listdir(self.folder).count("maps.json.tmp"), 0)
