"""Productions from outside: what is redone, what bytes depend on, and what happens when things go wrong.

usage: produce_test.py OPENHUMANBRDF [unittest's arguments]
OHB_KILLS=N in the environment: so many random kills (default 3; a few seconds each).
"""
import json
import os
import random
import shutil
import signal
import subprocess
import time
import unittest
from pathlib import Path

from dataset_support import BAD_INPUT, DIFFERENCE, DONE, MATERIALS, PROGRAM, TRY_AGAIN, Production, tree, write_hdr

KILLS = int(os.environ.get("OHB_KILLS", "3"))


class Redone(Production):
    """What a change touches, counted in sets."""

    def test_nothing_twice(self):
        report = self.produce()
        self.assertEqual(report["made"], 12)
        spent = report["worker_s"]
        self.assertEqual(set(spent), {"label", "bake", "loading", "environments", "maps", "lights", "writing"})
        self.assertTrue(0 < sum(spent.values()) <= report["seconds"], report)  # one worker
        before = tree(self.out)
        report = self.produce()
        self.assertEqual((report["made"], report["there"], report["worker_s"]), (0, 12, {}))
        self.assertEqual(tree(self.out), before)

    def test_a_class_that_only_one_person_wears(self):
        self.have_produced()
        before = tree(self.out)
        specular, _, sss = MATERIALS["leather"]
        self.write_plan(changed={"leather": (specular, 0.3, sss)})
        self.assertEqual(self.produce()["made"], 4)  # of c alone
        after = tree(self.out)
        different = {name for name in after if after[name] != before[name]}
        self.assertTrue(all(name.startswith("humans/c/") or name == "dataset.xml" for name in different), different)
        self.assertNotIn("humans/c/regions/faces.txt", different)
        fresh = self.folder / "fresh"
        self.produce(out=fresh)
        self.assertEqual(tree(fresh), after)
        self.write_plan()
        self.assertEqual(self.produce()["made"], 4)
        self.assertEqual(tree(self.out), before)

    def test_a_class_that_nobody_wears(self):
        self.have_produced()
        specular, _, sss = MATERIALS["hair"]
        self.write_plan(changed={"hair": (specular, 0.3, sss)})
        self.assertEqual(self.produce()["made"], 0)

    def test_an_environment(self):
        self.have_produced()
        drawn = 0
        for person in "abc":
            listing = json.loads((self.out / "humans" / person / "views/render.json").read_text())
            drawn += sum("noon" in view["environments"] for view in listing["views"])
        self.assertTrue(0 < drawn < 12)
        write_hdr(self.folder / "env/noon.hdr", value=(128, 128, 128, 131))
        self.assertEqual(self.produce()["made"], drawn)

    def test_a_scans_picture(self):
        self.have_produced()
        shutil.copy(self.folder / "people/a/colour.png", self.folder / "people/b/old.png")
        from small_scene import png
        png(self.folder / "people/b/colour.png", 32, lambda x, y: (8 * y, 8 * x, 64))
        self.assertEqual(self.produce()["made"], 4)

    def test_a_light_that_was_unpacked_over_the_old_one(self):
        """Of the same size and time, as archives keep them."""
        self.have_produced()
        for light in (self.folder / "env").iterdir():
            was = light.stat()
            write_hdr(light, value=(90, 90, 90, 131))
            os.utime(light, ns=(was.st_atime_ns, was.st_mtime_ns))
        self.assertEqual(self.produce()["made"], 12)

    def test_files_that_the_scan_finds_in_other_folders(self):
        from small_scene import png
        home = self.folder / "people/b"
        (home / "parts").mkdir()
        for name in ("scan.mtl", "colour.png"):
            (home / name).rename(home / "parts" / name)
        scan = home / "b_scan.obj"
        scan.write_text(scan.read_text().replace("scan.mtl", "parts/scan.mtl"))
        (home / "parts/colour.png").rename(home / "parts/COLOUR.png")    # found whatever its case
        self.write_plan(views=1)
        self.assertEqual(self.produce()["made"], 3)
        png(home / "parts/colour.png", 32, lambda x, y: (8 * y, 8 * x, 64))    # as it is written, so the first to be looked for
        self.assertEqual(self.produce()["made"], 1)
        library = home / "parts/scan.mtl"
        library.write_text(library.read_text().replace("map_Kd colour.png", "Kd 0.5 0.2 0.2", 1))
        self.assertEqual(self.produce()["made"], 1)
        self.assertEqual(self.produce()["made"], 0)

    def test_a_marker_that_names_files_outside(self):
        self.have_produced()
        marker = self.out / ".ohb/done/a/set_009.json"    # of no set of the plan: its files go
        mine = self.folder / "people/a/a_scan.obj"
        for path in ("../people/a/a_scan.obj", "humans/../../people/a/a_scan.obj", str(mine)):
            marker.write_text(json.dumps({"hash": "", "facts": {}, "files": [{"path": path, "size": 1, "sha256": ""}]}))
            self.assertEqual(self.produce()["made"], 0)
            self.assertTrue(mine.exists())
            self.assertFalse(marker.exists())

    def test_views_fewer_and_more(self):
        self.have_produced()
        self.write_plan(spp=4)
        self.assertEqual(self.produce()["made"], 12)
        self.write_plan(views=2, spp=4)
        self.assertEqual(self.produce()["made"], 6)  # other turns
        self.assertEqual(len(list(self.out.glob("humans/*/views/view_*.exr"))), 6)
        fresh = self.folder / "fresh"
        self.produce(out=fresh)
        self.assertEqual(tree(fresh), tree(self.out))

    def test_damage(self):
        self.have_produced()
        before = tree(self.out)
        views = self.out / "humans/a/views"
        (views / "view_000.exr").unlink()
        os.truncate(views / "view_001.exr", 100)
        (self.out / ".ohb/done/a/set_002.json").write_text("{")
        (self.out / ".ohb/done/a/set_003.json").unlink()
        (views / "render.json").unlink()
        self.assertEqual(self.produce()["made"], 4)
        self.assertEqual(tree(self.out), before)
        shutil.rmtree(self.out / "humans/b/model/maps")
        self.produce()
        self.assertEqual(tree(self.out), before)
        shutil.rmtree(self.out / ".ohb")
        self.produce()
        self.assertEqual(tree(self.out), before)


class SameBytes(Production):
    def test_workers_threads_and_shards(self):
        self.produce("--workers", 1)
        whole = tree(self.out)
        self.produce("--workers", 2, out=self.folder / "two")
        self.assertEqual(tree(self.folder / "two"), whole)
        shards = [self.start("--shard", "%d/3" % i, out=self.folder / "three") for i in (3, 1, 2)]
        for shard in shards:
            output = shard.communicate(timeout=120)[0]
            self.assertEqual(shard.returncode, DONE, output)
        self.assertEqual(tree(self.folder / "three"), whole)

    def test_automatic_labels(self):
        person = Path(__file__).resolve().parents[2] / "assets/example_human/example_human.glb"
        self.plan.write_text(
            '<plan schema="1" name="auto"><maps size_px="64"/><person id="a" scan="%s" labels="auto" split="train"/>'
            '<views split="train" count="2" size_px="32" error="0.5" max_spp="64" subsurface="diffuse" model="v2">'
            '<point x_cm="100" y_cm="200" z_cm="200" intensity="5"/></views></plan>' % person)
        self.produce()
        self.produce(out=self.folder / "again")
        self.assertEqual(tree(self.folder / "again"), tree(self.out))

    def test_after_random_kills(self):
        self.write_plan(views=8, size=64, spp=16)
        start = time.monotonic()
        self.produce("--workers", 2, out=self.folder / "whole")
        seconds = time.monotonic() - start
        whole = tree(self.folder / "whole")
        dice = random.Random(1)
        for k in range(KILLS):
            child = self.start("--workers", "2")
            end = time.monotonic() + dice.uniform(0, seconds)
            while time.monotonic() < end and child.poll() is None:
                workers = self.our_workers()
                if workers and dice.random() < 0.1:
                    self.kill(dice.choice(workers))
                time.sleep(0.02)
            child.kill()
            child.communicate()
            self.wait_for(lambda: not self.our_workers(), 10)
            if k % 3 == 2:  # often enough from the start
                shutil.rmtree(self.out, True)
        self.produce("--workers", 2)
        self.assertEqual(tree(self.out), whole)
        self.assertEqual([p for p in self.out.rglob(".*.tmp*")], [])


class Trouble(Production):
    def test_a_poisoned_person(self):
        labels = self.folder / "people/b/b_scan.labels.txt"
        good = labels.read_text()
        labels.write_text(good + "9\n")
        report = self.produce("--workers", 2, code=DIFFERENCE)
        self.assertEqual([p["id"] for p in report["given_up"]], ["b"])
        self.assertIn("b_scan.labels.txt", report["given_up"][0]["reason"])
        self.assertEqual(report["made"], 8)
        self.assertIn("b_scan.labels.txt", (self.out / ".ohb/quarantine/b.txt").read_text())
        self.assertNotIn('id="b"', (self.out / "dataset.xml").read_text())
        labels.write_text(good)
        self.assertEqual(self.produce()["made"], 4)
        self.assertFalse((self.out / ".ohb/quarantine/b.txt").exists())

    def test_a_worker_that_is_always_killed(self):
        child = self.start("--workers", "2", "--json")
        while child.poll() is None:
            for pid in self.our_workers("b"):
                self.kill(pid)
            time.sleep(0.02)
        self.assertEqual(child.returncode, DIFFERENCE)
        output = child.communicate()[0]
        self.assertIn("signal 9", output)
        self.assertIn('"retries": 2', output)

    def test_a_worker_that_stalls(self):
        child = self.start("--stall", "2", "--json")
        self.wait_for(lambda: self.our_workers())
        self.kill(self.our_workers()[0], signal.SIGSTOP)
        output = child.communicate(timeout=200)[0]
        self.assertEqual(child.returncode, DONE, output)
        self.assertIn("no sign of life", output)
        self.assertEqual(self.produce()["there"], 12)

    def test_sigterm(self):
        self.write_plan(views=4, size=256, spp=4096)
        child = self.start("--workers", "2")
        self.wait_for(lambda: len(self.our_workers()) == 2)
        time.sleep(1)
        start = time.monotonic()
        child.terminate()
        output = child.communicate(timeout=30)[0]
        self.assertLess(time.monotonic() - start, 5)
        self.assertEqual(child.returncode, TRY_AGAIN, output)
        self.assertEqual(self.our_workers(), [])
        self.assertEqual([p for p in self.out.rglob(".*.tmp*")], [])

    def test_the_supervisor_is_killed(self):
        self.write_plan(views=4, size=256, spp=4096)
        child = self.start("--workers", "2")
        self.wait_for(lambda: len(self.our_workers()) == 2)
        child.kill()
        self.wait_for(lambda: not self.our_workers(), 5)

    def test_two_supervisors(self):
        self.write_plan(views=4, size=256, spp=4096)
        child = self.start()
        self.wait_for(lambda: self.our_workers())
        self.produce(code=TRY_AGAIN)
        self.assertIn("of this shard", self.one_line())
        other = self.write_plan(views=2, name="other.xml")
        self.produce("--shard", "1/2", plan=other, code=TRY_AGAIN)
        self.assertIn("another plan", self.one_line())
        child.terminate()
        child.communicate(timeout=30)

    def test_another_shard_leaves_a_busy_person_alone(self):
        self.write_plan(views=1, size=256, spp=4096)
        child = self.start()
        self.wait_for(lambda: self.our_workers("a"))
        time.sleep(0.5)
        report = self.produce("--shard", "1/3", code=TRY_AGAIN)
        self.assertEqual(report["busy"], ["a"])
        child.terminate()
        child.communicate(timeout=30)

    def test_the_plan_changes_meanwhile(self):
        self.write_plan(views=4, size=128, spp=256)
        child = self.start()
        self.wait_for(lambda: self.our_workers("a"))
        self.write_plan()
        output = child.communicate(timeout=120)[0]
        self.assertEqual(child.returncode, TRY_AGAIN)
        self.assertIn("changed while", output)
        self.produce()
        fresh = self.folder / "fresh"
        self.produce(out=fresh)
        self.assertEqual(tree(fresh), tree(self.out))

    def test_an_environment_vanished(self):
        self.have_produced()
        (self.folder / "env/noon.hdr").unlink()
        (self.folder / "env/dusk.hdr").unlink()
        self.produce(code=BAD_INPUT)
        self.assertIn("2 different environments", self.one_line())

    def test_folders_of_others(self):
        self.out.mkdir()
        (self.out / "thesis.txt").write_text("mine")
        self.produce(code=BAD_INPUT)
        self.assertIn("not written by this program", self.one_line())
        self.assertEqual([p.name for p in self.out.iterdir()], ["thesis.txt"])

    def test_a_newer_version(self):
        self.have_produced()
        (self.out / ".ohb/plan.json").write_text('{"schema": 9, "version": "9.0", "plan": "p", "sha256": ""}')
        self.produce(code=BAD_INPUT)
        self.assertIn("newer version", self.one_line())

    def test_a_clock_that_jumps(self):
        self.have_produced()
        for path in [*self.out.rglob("*.exr"), *self.out.rglob("*.json")]:
            os.utime(path, (4e9, 4e9))
        self.assertEqual(self.produce()["made"], 0)


@unittest.skipUnless(os.geteuid() == 0 and shutil.which("mount"), "needs root")
class Disks(Production):
    def setUp(self):
        super().setUp()
        self.out.mkdir()
        if self.mount("size=700k") != 0:
            self.skipTest("no file system can be mounted here")
        self.addCleanup(subprocess.run, ["umount", "-l", str(self.out)])

    def mount(self, options):
        return subprocess.run(["mount", "-t", "tmpfs", "-o", options, "ohb", str(self.out)], stderr=subprocess.DEVNULL).returncode

    def test_full(self):
        self.write_plan(size=64)
        self.produce(out=self.folder / "whole")
        self.produce("--workers", 2, code=TRY_AGAIN)
        self.assertIn("free some space", self.stderr)
        self.assertFalse((self.out / ".ohb/quarantine").exists())
        self.mount("remount,size=900k")
        self.produce("--workers", 2, code=TRY_AGAIN)
        self.mount("remount,size=64m")
        self.produce("--workers", 2)
        self.assertEqual(tree(self.out), tree(self.folder / "whole"))

    def test_read_only(self):
        self.mount("remount,size=64m")
        self.produce()
        before = tree(self.out)
        self.mount("remount,ro")
        self.produce(code=BAD_INPUT)
        self.assertIn("cannot be written", self.one_line())
        self.assertEqual(tree(self.out), before)


if __name__ == "__main__":
    assert os.path.exists(PROGRAM), PROGRAM
    unittest.main(verbosity=2)
