"""Hostile and broken maps folders: a report in words; scene and files stay as they were."""
import hashlib
import math
import os

import bpy
from support import image_files, maps_folder, scene as s

PERSON = maps_folder.Person(16, 16)


def values_with(name, value, place=8 * 16 + 8):
    values = PERSON.maps()[name]
    values[place * len(values) // 256] = value
    return {name: values}


def cut(name, keep):
    def change(folder):
        path = os.path.join(folder, name)
        with open(path, "rb") as file:
            data = file.read()
        with open(path, "wb") as file:
            file.write(data[:int(keep * len(data))])
    return change


def edit_json(**entries):
    """Changes keys of a map's entry: edit_json(normal={"encoding": "offset"})."""
    def change(folder):
        content = maps_folder.write(folder, PERSON)
        for name, changed in entries.items():
            content["maps"][name].update(changed)
        maps_folder.write_json(folder, content)
    return change


def put(name, data):
    def change(folder):
        with open(os.path.join(folder, name), "wb") as file:
            file.write(data)
    return change


def other_size(folder):
    image_files.exr(os.path.join(folder, "sss.exr"), 8, 16, [0.0] * 128, "Y")


def garbage_png(folder):
    """A PNG whose frame is whole and whose pixels are noise."""
    path = os.path.join(folder, "mask.png")
    image_files.png(path, 16, 16, [255] * 256, 1, 8)
    with open(path, "rb") as file:
        data = bytearray(file.read())
    data[45:60] = b"\xff" * 15
    put("mask.png", bytes(data))(folder)
    content = maps_folder.write(folder, PERSON)
    content["maps"]["mask"]["file"] = "mask.png"
    maps_folder.write_json(folder, content)


#: what is done to a good folder -> words of the report
HOSTILE = {
    "missing file": (lambda folder: os.remove(os.path.join(folder, "normal.exr")), "no such file"),
    "missing maps.json": (lambda folder: os.remove(os.path.join(folder, "maps.json")), "no such file"),
    "cut off JSON": (cut("maps.json", 0.5), "is not JSON"),
    "cut off EXR": (cut("displacement.exr", 0.7), "cut off"),
    "empty image": (put("sss.exr", b""), "empty"),
    "text for an image": (put("sss.exr", b"hello, this is text"), "neither PNG nor OpenEXR"),
    "garbage in a PNG": (garbage_png, "mask.png"),
    "unknown encoding": (edit_json(specular={"encoding": "albedo"}), "maps.specular.encoding"),
    "signed normals called offset": (edit_json(normal={"encoding": "offset"}), "median length"),
    "EXR albedo called srgb": (edit_json(diffuse={"encoding": "srgb"}), "needs PNG"),
    "one size wrong": (other_size, "8 x 16"),
    "one channel for a colour": (edit_json(diffuse={"file": "sss.exr"}), "1 channel, 3 are needed"),
    "file outside": (edit_json(diffuse={"file": "../../etc/passwd"}), "outside"),
    "NaN": (values_with("roughness", math.nan), "pixel (8, 8): is NaN"),
    "infinite depth": (values_with("displacement", math.inf), "pixel (8, 8): is NaN or infinite"),
    "NaN in the mask": (values_with("mask", math.nan, 0), "pixel (0, 0): is NaN"),
    "behind the camera": (values_with("displacement", 500.0), "behind the camera"),
    "roughness beyond 1": (values_with("roughness", 7.0), "outside [0, 1]"),
    "empty mask": ({"mask": [0.0] * 256}, "covers nothing"),
    "normals to the back": ({"normal": PERSON.raster(lambda x, y: (0.0, 0.0, -1.0))}, "away from the viewer"),
}


class BadInput(s.Registered):
    def prepared(self, change):
        folder = os.path.join(s.folder(), "person")
        maps_folder.write(folder, PERSON, change if isinstance(change, dict) else None)
        if callable(change):
            change(folder)
        return folder

    def snapshot(self, folder):
        hashes = {}
        for name in sorted(os.listdir(folder)):
            with open(os.path.join(folder, name), "rb") as file:
                hashes[name] = hashlib.sha256(file.read()).hexdigest()
        return hashes, s.data_counts(), bpy.context.scene.camera

    def test_hostile_folders(self):
        for what, (change, words) in HOSTILE.items():
            with self.subTest(what):
                folder = self.prepared(change)
                before = self.snapshot(folder)
                with self.assertRaises(RuntimeError) as caught:
                    bpy.ops.hm.import_maps(filepath=os.path.join(folder, "maps.json"))
                self.assertIn(words, str(caught.exception))
                self.assertNotIn("Traceback", str(caught.exception))
                self.assertEqual(self.snapshot(folder), before)

    def test_good_folder_through_the_operators(self):
        folder = self.prepared({})
        self.assertEqual(bpy.ops.hm.import_maps(filepath=os.path.join(folder, "maps.json")), {"FINISHED"})
        self.assertEqual(bpy.ops.hm.apply_preset(class_name="hair", preset="red"), {"FINISHED"})
        self.assertEqual(bpy.ops.hm.reset_edit(class_name="hair"), {"FINISHED"})
        self.assertEqual(bpy.ops.hm.match_camera(), {"FINISHED"})
        self.assertEqual(bpy.ops.hm.add_point_light(), {"FINISHED"})
        self.assertEqual(bpy.ops.hm.prepare_render(), {"FINISHED"})
        bpy.context.scene.hm.subsurface_scale = 0.5
        bpy.context.scene.hm.rotation_deg = 30
        picture = os.path.join(s.folder(), "relit.png")
        bpy.context.scene.hm.samples = 1
        self.assertEqual(bpy.ops.hm.render_picture(filepath=picture), {"FINISHED"})
        self.assertEqual(os.listdir(os.path.dirname(picture)), ["relit.png"])

    def test_environments(self):
        folder = s.folder()
        square = os.path.join(folder, "square.exr")
        image_files.exr(square, 8, 8, [1.0] * 192)
        low = os.path.join(folder, "low.png")
        image_files.png(low, 8, 4, [9] * 96, 3, 8)
        text = os.path.join(folder, "text.exr")
        put("text.exr", b"nothing")(folder)
        for path, words in ((square, "not twice as wide"), (low, "8 bits"), (text, "decoded"),
                            (os.path.join(folder, "none.exr"), "no such file")):
            before = s.data_counts()
            with self.assertRaises(RuntimeError) as caught:
                bpy.ops.hm.set_environment(filepath=path)
            self.assertIn(words, str(caught.exception))
            self.assertEqual(s.data_counts(), before)

    def test_nothing_selected(self):
        with self.assertRaises(RuntimeError) as caught:
            bpy.ops.hm.apply_preset()
        self.assertIn("Select a person", str(caught.exception))

    def test_unwritable_pictures(self):
        bpy.ops.hm.import_maps(filepath=self.prepared({}))
        for path, words in (("/nowhere/at/all.png", "no folder"), (s.folder(), "neither .png"),
                            (os.path.join(s.folder(), "a.jpg"), "neither .png")):
            with self.assertRaises(RuntimeError) as caught:
                bpy.ops.hm.render_picture(filepath=path)
            self.assertIn(words, str(caught.exception))
