"""What the tests of openhumanbrdf share: running it, reading what it refuses, and a small model to work on."""
import hashlib
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from small_scene import write_hdr, write_scan

DONE, BAD_INPUT, TRY_AGAIN = 0, 2, 75


class Program:
    """openhumanbrdf, by the path that ctest gives."""
    path = None


def run(*arguments, file_size_limit=None):
    def limit():
        if file_size_limit is not None:
            resource.setrlimit(resource.RLIMIT_FSIZE, (file_size_limit, file_size_limit))
    return subprocess.run([Program.path, *map(str, arguments)], capture_output=True, text=True, preexec_fn=limit, timeout=300)


def digest(folder):
    files = sorted(p for p in folder.rglob("*") if p.is_file() and p.name != "render.json")
    return {str(p.relative_to(folder)): hashlib.sha256(p.read_bytes()).hexdigest() for p in files}


class Case(unittest.TestCase):
    """A test of openhumanbrdf with a scan, its regions, its model and an environment in a folder of their own."""

    @classmethod
    def setUpClass(cls):
        cls.folder = Path(tempfile.mkdtemp(prefix="ohb-cli-"))
        cls.scan = write_scan(cls.folder)
        cls.environment = write_hdr(cls.folder / "grey.hdr")
        for arguments in (["label", cls.scan, "-o", cls.folder / "regions"],
                          ["bake", cls.scan, "--regions", cls.folder / "regions", "--size", 64, "-o", cls.folder / "model"]):
            result = run(*arguments)
            assert result.returncode == DONE, result.stderr

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    def render(self, output, *more, **keywords):
        return run("render", self.folder / "model", "--environment", self.environment, "--size", 48, "--spp", 8,
                   "--views", "4:0,1", "-o", output, *more, **keywords)

    def expect_refusal(self, result, *words):
        self.assertEqual(result.returncode, BAD_INPUT, result.stderr)
        self.assertEqual(result.stdout, "")
        lines = [line for line in result.stderr.splitlines() if not line.startswith("warning:")]
        self.assertEqual(len(lines), 1, result.stderr)
        for word in words:
            self.assertIn(word, lines[0])

    def leftovers(self):
        return [p.name for p in self.folder.iterdir() if ".tmp" in p.name or ".old" in p.name]


def main():
    """Runs the tests of the script that calls it; its first argument is the program."""
    Program.path = os.path.abspath(sys.argv.pop(1))
    unittest.main(verbosity=2)
