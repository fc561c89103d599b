"""The Python reader: the C++ reader's bits, splits, refusals, the examples of docs/python.md.

usage: reader_test.py SOURCE_DIR OPENHUMANBRDF DUMP_SAMPLE
"""
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

SKIPPED = 77
if __name__ == "__main__" and os.environ.get("OHB_PYTHON", sys.executable) != sys.executable and "OHB_PYTHON_USED" not in os.environ:
    os.environ["OHB_PYTHON_USED"] = "1"
    os.execv(os.environ["OHB_PYTHON"], [os.environ["OHB_PYTHON"], *sys.argv])
SOURCE, PROGRAM, DUMP = (Path(word).resolve() for word in sys.argv[1:4])
sys.path.insert(0, str(SOURCE / "dataset/python"))
try:
    import numpy as np
    import OpenEXR
    if not hasattr(OpenEXR, "File"):
        raise ImportError("OpenEXR is older than 3.3")
except ImportError as error:
    print("SKIPPED: the Python reader is NOT tested: %s (pip install numpy 'OpenEXR>=3.3', or name such a Python in OHB_PYTHON)" % error)
    sys.exit(SKIPPED)
from openhumanbrdf import FIELDS, Dataset, DatasetError, read_sample  # noqa: E402

PLAN = """<?xml version="1.0"?>
<plan schema="1" name="tiny" seed="1">
  <maps size_px="64"/>
  <person id="ann" scan="{human}.glb" labels="{human}.labels.txt" split="train" age="30"/>
  <person id="bob" scan="{human}.glb" labels="{human}.labels.txt" split="test" age="40"/>
  <environments id="bundled" folder="{lights}"/>
  <views split="train" count="2" size_px="48" spp="2"><lights from="bundled" count="2"/></views>
  <views split="test" count="1" size_px="48" spp="2"><lights from="bundled" count="1"/></views>
</plan>"""


def dumped(file):
    data, images = subprocess.run([DUMP, file], check=True, capture_output=True).stdout, {}
    while data:
        line, data = data.split(b"\n", 1)
        name, width, height, channels = line.decode().split()
        shape = (int(height), int(width), int(channels))
        size = 4 * shape[0] * shape[1] * shape[2]
        images[name] = np.frombuffer(data[:size], np.float32).reshape(shape)
        data = data[size:]
    return images


class Reader(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory(prefix="ohb-python-")
        cls.root = Path(cls.temporary.name)
        cls.whole = cls.root / "whole"
        plan = cls.root / "plan.xml"
        plan.write_text(PLAN.format(human=SOURCE / "assets/example_human/example_human", lights=SOURCE / "assets/environments"))
        subprocess.run([PROGRAM, "produce", plan, "-o", cls.whole], check=True, capture_output=True)

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def copy(self):
        folder = self.root / self.id().split(".")[-1]
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(self.whole, folder)
        return folder

    def refusal(self, path, **options):
        with self.assertRaises(DatasetError) as caught:
            Dataset(path, **options)
        self.assertNotIn("\n", str(caught.exception))
        return str(caught.exception)

    def test_bits_are_those_of_the_cpp_reader(self):
        dataset, compared = Dataset(self.whole), 0
        for sample in dataset:
            images = dumped(sample.file)
            mine = {**sample, **{"relit." + name: array for name, array in sample.lights.items()}}
            self.assertEqual(set(mine), set(images))
            for name, array in mine.items():
                self.assertEqual(array.dtype, np.float32)
                self.assertEqual(array.reshape(images[name].shape).tobytes(), images[name].tobytes(), name)
                compared += 1
        maps = len(FIELDS) - 1   # but the lights: two, two and one
        self.assertEqual(compared, 3 * maps + 5)

    def test_splits_people_and_choices(self):
        self.assertEqual(len(Dataset(self.whole)), 3)
        self.assertEqual(Dataset(self.whole, split="test").people, ["bob"])
        self.assertEqual([s.view for s in Dataset(self.whole, people=["ann"])], [0, 1])
        sample = Dataset(self.whole, maps=["mask"], lights=[])[-1]
        self.assertEqual((list(sample), sample.lights, sample.split), (["mask"], {}, "test"))
        self.assertEqual(sample["mask"].shape, (48, 48))
        self.assertEqual(len(Dataset(self.whole / "humans")), 3)
        self.assertEqual(len(Dataset(self.whole / "humans/ann/views")), 2)
        self.assertIn("no samples", self.refusal(self.whole, split="val"))
        with self.assertRaises(DatasetError):
            Dataset(self.whole, maps=["colour"])[0]
        with self.assertRaises(DatasetError):
            Dataset(self.whole, lights=["moon"])[0]

    def test_paths_names_and_places_as_python_has_them(self):
        mine = Dataset(os.fsencode(self.whole), maps=(name for name in ["mask"]), lights=[])
        self.assertEqual([list(s) for s in mine], [["mask"]] * 3, "a generator lasts for all samples")
        self.assertEqual([s.view for s in mine[-3:-1]], [0, 1])
        self.assertEqual(len(Dataset(self.whole, people="ann")), 2)
        self.assertIn("'an'", self.refusal(self.whole, people="an"))
        self.assertIn("'eve'", self.refusal(self.whole, people=(name for name in ["ann", "eve"])))
        self.assertIn("empty", self.refusal(""))
        self.assertIn("cannot be read", self.refusal("n" * 300))
        self.assertEqual(len(read_sample(os.fsencode(mine.entries[0].file))), 3)
        with self.assertRaises(TypeError):
            read_sample(None)
        pipe = self.root / "view\n000.exr"
        os.mkfifo(pipe)
        with self.assertRaisesRegex(DatasetError, "^[^\n]*no such file[^\n]*$"):
            read_sample(pipe)

    def test_unfinished_and_mixed_folders_are_refused(self):
        folder = self.copy()
        views = folder / "humans/ann/views"
        shutil.copy(views / "view_000.exr", views / "view_007.exr")
        self.assertIn("view_007.exr", self.refusal(folder))
        (views / "view_007.exr").unlink()
        shutil.copy(folder / "humans/bob/views/view_000.exr", views / "view_001.exr")
        self.assertIn("other settings", self.refusal(folder))
        (views / "view_001.exr").unlink()
        self.assertIn("missing", self.refusal(folder))
        (views / "render.json").unlink()
        self.assertIn("no render.json", self.refusal(folder))
        self.assertIn("no render.json", self.refusal(views))
        self.assertIn("no such folder", self.refusal(folder / "nowhere"))
        manifest = (folder / "dataset.xml").read_text()
        changes = [('planned_sets="1"', 'planned_sets="9"', "lacks 8 sets"), ('schema="1"', 'schema="9"', "newer"),
                   ('schema="1"', 'schema="\u00b2"', "no list of a dataset"),
                   ('views="humans/bob/views"', 'views="../x"', "outside"), ("</dataset>", "", "damaged"),
                   (' sets="1"', "", "lacks"), ("<dataset ", "<datas ", "damaged")]
        for old, new, words in changes:
            self.assertIn(old, manifest)
            (folder / "dataset.xml").write_text(manifest.replace(old, new))
            self.assertIn(words, self.refusal(folder, people=["bob"]))
        (folder / "dataset.xml").write_text(manifest.replace('planned_sets="1"', 'planned_sets="9"'))
        self.assertEqual(len(Dataset(folder, people=["bob"], unfinished=True)), 1)

    def test_damaged_listings_and_files(self):
        folder = self.copy() / "humans/ann/views"
        good = (folder / "render.json").read_text()
        for bad in ("", "[]", "{}", "nul", good[:100], good.replace("view_000.exr", "../view_000.exr"), "[" * 100000):
            (folder / "render.json").write_text(bad)
            self.assertIn("render.json", self.refusal(folder))
        listing = json.loads(good)
        listing["settings"]["ohb:spp"] = "3"
        (folder / "render.json").write_text(json.dumps(listing))
        self.assertIn("changed", self.refusal(folder))
        listing = json.loads(good)
        listing["views"].append(listing["views"][0])
        (folder / "render.json").write_text(json.dumps(listing))
        self.assertIn("twice", self.refusal(folder))
        (folder / "render.json").write_text(good)
        whole = (folder / "view_001.exr").read_bytes()
        shutil.copy(folder / "view_000.exr", folder / "view_001.exr")
        self.assertIn("view_001.exr: is view 0", self.refusal(folder))
        for cut in (0, 10, 500):
            (folder / "view_001.exr").write_bytes(whole[:cut])
            self.assertIn("view_001.exr", self.refusal(folder))
        (folder / "view_001.exr").write_bytes(whole[:len(whole) // 2])
        with self.assertRaises(DatasetError):
            read_sample(folder / "view_001.exr")

    def test_examples_of_the_documentation(self):
        text = (SOURCE / "docs/python.md").read_text()
        folder = self.copy()
        folder.rename(folder.parent / "dataset")
        for block in re.findall(r"```python\n(.*?)```", text, re.DOTALL):
            block = block.replace('"h0001"', '"ann"')
            if "torch" in block:
                try:
                    import torch  # noqa: F401
                except ImportError as error:
                    print("SKIPPED: TorchDataset is NOT tested: %s" % error)
                    continue
            result = subprocess.run([sys.executable, "-c", block], cwd=folder.parent, capture_output=True, text=True,
                                    env={**os.environ, "PYTHONPATH": os.pathsep.join([str(SOURCE / "dataset/python"), *sys.path[1:]])})
            self.assertEqual(result.returncode, 0, result.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
