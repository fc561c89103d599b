"""Small people, a plan, and running `produce`: what the tests of productions share."""
import hashlib
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "cli"))
from small_scene import write_hdr, write_scan  # noqa: E402

DONE, DIFFERENCE, BAD_INPUT, TRY_AGAIN = 0, 1, 2, 75
PROGRAM = os.path.abspath(sys.argv.pop(1)) if len(sys.argv) > 1 else "openhumanbrdf"
SKIN, HAIR, FABRIC, LEATHER = range(4)
MATERIALS = {"skin": (0.184, 0.4, 0.08), "hair": (0.239, 0.5, 0), "fabric": (0.263, 0.85, 0), "leather": (0.224, 0.25, 0)}


def tree(folder):
    """Hash of every file of a dataset, by name; not of what only production needs."""
    files = sorted(p for p in Path(folder).rglob("*") if p.is_file() and ".ohb" not in p.relative_to(folder).parts)
    return {str(p.relative_to(folder)): hashlib.sha256(p.read_bytes()).hexdigest() for p in files}


def workers_of(person=""):
    """Process ids of workers (of one person) of ours, from /proc."""
    found = []
    for entry in Path("/proc").iterdir():
        if not entry.name.isdigit():
            continue
        try:
            words = (entry / "cmdline").read_bytes().decode(errors="replace").split("\0")
        except OSError:
            continue
        if "--worker" in words and "produce" in words and (not person or words[words.index("--worker") + 1] == person):
            found.append((int(entry.name), words))
    return found


class Production(unittest.TestCase):
    """Three people: a and b wear fabric, c wears leather. Two environments of three light each set."""

    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="ohb-produce-"))
        self.addCleanup(shutil.rmtree, self.folder, True)
        for name, worn in (("a", FABRIC), ("b", FABRIC), ("c", LEATHER)):
            (self.folder / "people" / name).mkdir(parents=True)
            scan = write_scan(self.folder / "people" / name)
            scan.rename(scan.with_name(name + "_scan.obj"))
            scan.with_name(name + "_scan.labels.txt").write_text("".join("%d\n" % c for c in (worn, SKIN, worn, SKIN, worn, worn)))
        (self.folder / "env").mkdir()
        for name, value in (("dawn", (200, 128, 64, 129)), ("noon", (128, 128, 128, 130)), ("dusk", (60, 90, 200, 128))):
            write_hdr(self.folder / "env" / (name + ".hdr"), value=value)
        self.plan = self.write_plan()
        self.out = self.folder / "out"

    def write_plan(self, views=4, size=16, spp=2, changed=None, name="plan.xml"):
        rows = "".join('<material class="%s" specular="%g" roughness="%g" sss="%g"/>' % (c, *(changed or {}).get(c, m))
                       for c, m in MATERIALS.items())
        text = ('<plan schema="1" name="test"><maps size_px="32"/><materials specular_encoding="srgb-f0" '
                'roughness_encoding="perceptual" sss_encoding="weight-1.0-0.2-0.1-cm">%s</materials>'
                '<people folder="people" split="train"/><environments id="e" folder="env"/>'
                '<views split="train" count="%d" size_px="%d" spp="%d"><lights from="e" count="2"/></views></plan>')
        plan = self.folder / name
        plan.write_text(text % (rows, views, size, spp))
        return plan

    finished = {}

    @classmethod
    def tearDownClass(cls):
        for folder in cls.finished.values():
            shutil.rmtree(folder, True)
        cls.finished.clear()

    def have_produced(self):
        """The plan's dataset, made once for all tests of a class with this plan: a copy in another folder is as good."""
        text = self.plan.read_text()
        if text not in self.finished:
            self.finished[text] = tempfile.mkdtemp(prefix="ohb-finished-")
            self.produce("--workers", 2, out=Path(self.finished[text]) / "out")
        shutil.copytree(Path(self.finished[text]) / "out", self.out, symlinks=True)
        self.assertEqual(self.produce()["made"], 0)  # of this folder's plan now

    def command(self, *more, out=None, plan=None):
        return [PROGRAM, "produce", str(plan or self.plan), "-o", str(out or self.out), "--threads", "2", *map(str, more)]

    def produce(self, *more, code=DONE, **where):
        result = subprocess.run(self.command(*more, "--json", **where), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                stderr=subprocess.PIPE, text=True, timeout=300)
        self.assertEqual(result.returncode, code, result.stdout + result.stderr)
        self.stderr = result.stderr
        return json.loads(result.stdout) if result.stdout.startswith("{") else {}

    def start(self, *more, **where):
        child = subprocess.Popen(self.command(*more, **where), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                 stderr=subprocess.STDOUT, text=True)
        self.addCleanup(lambda: child.poll() is None and (child.kill(), child.communicate()))
        return child

    def our_workers(self, person=""):
        return [pid for pid, words in workers_of(person) if str(self.out) in words]

    def wait_for(self, condition, seconds=60):
        end = time.monotonic() + seconds
        while not condition():
            self.assertLess(time.monotonic(), end, "it did not happen")
            time.sleep(0.005)

    def one_line(self):
        self.assertEqual(len(self.stderr.strip().splitlines()), 1, self.stderr)
        return self.stderr

    def kill(self, pid, number=signal.SIGKILL):
        try:
            os.kill(pid, number)
        except ProcessLookupError:
            pass
