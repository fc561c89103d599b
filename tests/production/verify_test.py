"""`status` and `verify`: each kind of damage is named with its place, and a dataset in order has none.

usage: verify_test.py OPENHUMANBRDF [unittest's arguments]
"""
import json
import os
import shutil
import subprocess
import time
import unittest

from dataset_support import BAD_INPUT, DIFFERENCE, DONE, PROGRAM, TRY_AGAIN, Production, write_hdr


class Looks(Production):
    def look(self, command, *more, code=DONE):
        result = subprocess.run([PROGRAM, command, str(self.out), *map(str, more)], stdin=subprocess.DEVNULL,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=120)
        self.assertEqual(result.returncode, code, result.stdout + result.stderr)
        self.stderr = result.stderr
        return json.loads(result.stdout) if "--json" in more and result.stdout else result.stdout

    def faults(self, *more):
        report = self.look("verify", "--json", "--rerender", 0, *more, code=DIFFERENCE)
        return {fault["where"]: fault["what"] for fault in report["faults"]}

    def only_fault(self, where, words):
        found = self.faults()
        self.assertEqual(list(found), [where], found)
        self.assertIn(words, found[where])


class Verify(Looks):
    def setUp(self):
        super().setUp()
        self.write_plan(size=32, spp=16)
        self.have_produced()

    def test_all_is_well(self):
        report = self.look("verify", "--json", "--rerender", 12)
        self.assertEqual((report["people"], report["sets"], report["planned_sets"], report["faults"]), (3, 12, 12, []))
        self.assertEqual(len(report["rerendered"]), 12)
        self.assertEqual(report["notes"], ["nobody shows hair"])
        self.assertGreater(report["class_share"]["leather"], 0.01)
        self.assertIn("all is well", self.look("verify"))

    def test_files(self):
        views = self.out / "humans/a/views"
        os.truncate(views / "view_000.exr", 1000)
        (views / "view_001.exr").unlink()
        data = bytearray((self.out / "humans/b/model/mesh.obj").read_bytes())
        data[-3] ^= 1
        (self.out / "humans/b/model/mesh.obj").write_bytes(data)
        (views / "view_099.exr").write_bytes(b"x")
        (self.out / "humans/stranger").mkdir()
        found = self.faults()
        for where, words in (("humans/a/views/view_000.exr", ""), ("humans/a/views/view_001.exr", "missing"),
                             ("humans/b/model/mesh.obj", "another content"), ("humans/a/views/view_099.exr", "no finished unit"),
                             ("humans/stranger", "nobody of the plan")):
            self.assertIn(words, found.pop(where))
        self.assertEqual(found, {})
        self.produce()
        self.assertEqual(set(self.faults()), {"humans/a/views/view_099.exr", "humans/stranger", "humans/b/model/mesh.obj"})

    def test_a_view_of_another_set(self):
        """Bytes and marker agree: the header tells."""
        views, done = self.out / "humans/a/views", self.out / ".ohb/done/a"
        shutil.copy(views / "view_001.exr", views / "view_000.exr")
        marker, other = (json.loads((done / ("set_%03d.json" % k)).read_text()) for k in (0, 1))
        marker["files"][0].update({key: other["files"][0][key] for key in ("size", "sha256")})
        (done / "set_000.json").write_text(json.dumps(marker))
        report = self.look("verify", "--json", "--rerender", 0, code=DIFFERENCE)
        self.assertIn("is of set 1", [f["what"] for f in report["faults"] if f["where"].endswith("view_000.exr")])

    def test_a_light_that_is_another_one_now(self):
        """The images are rendered again, with markers that believe all is well."""
        write_hdr(self.folder / "env/noon.hdr", value=(200, 60, 60, 130))
        report = self.look("verify", "--json", "--rerender", 12, code=DIFFERENCE)
        self.assertTrue(any("of another plan, light or version" in f["what"] for f in report["faults"]))
        again = {f["where"] for f in report["faults"] if "relit.noon differs" in f["what"]}
        drawn = set()
        for person in "abc":
            listing = json.loads((self.out / "humans" / person / "views/render.json").read_text())
            drawn |= {"humans/%s/views/%s" % (person, v["file"]) for v in listing["views"] if "noon" in v["environments"]}
        self.assertEqual(again, drawn)

    def test_missing_sets_and_people(self):
        (self.out / ".ohb/done/a/set_002.json").unlink()
        shutil.rmtree(self.out / ".ohb/done/c")
        found = self.faults()
        self.assertIn("1 sets are missing", found["a"])
        self.assertIn("is not baked", found["c"])
        (self.out / "dataset.xml").unlink()
        self.assertIn("dataset.xml", self.faults())

    def test_people_and_splits(self):
        for name, old, new in (("splits.xml", 'name="train"', 'name="test" '), ("dataset.xml", 'split="train"', 'split="test" ')):
            file, good = self.out / name, (self.out / name).read_text()
            self.assertIn(old, good)
            file.write_text(good.replace(old, new, 1))
            self.only_fault(name, "another content")
            self.produce()
            self.assertEqual(file.read_text(), good)

    def test_a_changed_plan(self):
        self.write_plan(size=32, spp=17)
        found = self.faults()
        self.assertEqual({k for k in found}, {"a", "b", "c"})
        self.assertIn("of another plan", found["a"])

    def test_not_a_dataset(self):
        self.out = self.folder / "people"
        for command in ("verify", "status"):
            self.look(command, code=BAD_INPUT)
            self.assertIn("is no dataset", self.one_line())
        self.out = self.folder / "out"
        self.plan.unlink()
        for command in ("verify", "status"):
            self.look(command, code=BAD_INPUT)
            self.assertIn("plan.xml", self.one_line())


class Status(Looks):
    def test_through_a_production(self):
        self.write_plan(views=4, size=64, spp=256)
        child = self.start("--workers", "2")
        self.wait_for(lambda: (self.out / ".ohb/plan.json").exists())
        self.wait_for(lambda: self.our_workers("a"))
        self.wait_for(lambda: self.look("status", "--json")["sets"] >= 2)
        status = self.look("status", "--json")
        self.assertEqual(status["planned_sets"], 12)
        self.assertGreater(status["sets_per_hour"], 0)
        if status["sets"] < 12:
            self.assertTrue(any(p["at_work"] for p in status["people"]), status)
            self.assertIn("left", self.look("status"))
        self.assertEqual(child.wait(120), DONE)
        status = self.look("status", "--json")
        self.assertEqual((status["sets"], status["done_people"]), (12, 3))
        self.assertFalse(any(p["at_work"] for p in status["people"]))
        self.assertIn("12 of 12 sets", self.look("status", "--watch"))

    def test_failures_and_changes(self):
        (self.folder / "people/b/b_scan.labels.txt").write_text("7\n")
        self.produce(code=DIFFERENCE)
        status = self.look("status", "--json")
        self.assertIn("labels.txt", [p["failure"] for p in status["people"] if p["id"] == "b"][0])
        self.assertIn("given up", self.look("status"))
        self.assertFalse(status["plan_changed"])
        self.write_plan(spp=3)
        self.assertTrue(self.look("status", "--json")["plan_changed"])

    def test_watch_ends_by_a_signal(self):
        (self.folder / "people/b/b_scan.labels.txt").write_text("7\n")
        self.produce(code=DIFFERENCE)
        child = subprocess.Popen([PROGRAM, "status", str(self.out), "--watch"], stdout=subprocess.PIPE, text=True)
        time.sleep(1)
        child.terminate()
        child.communicate(timeout=10)
        self.assertEqual(child.returncode, TRY_AGAIN)


if __name__ == "__main__":
    unittest.main(verbosity=2)
