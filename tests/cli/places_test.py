"""Places and names as they come: none of them is a bug of ours, none lets a command wait for ever.

usage: places_test.py OPENHUMANBRDF [HUMANMATERIAL] [unittest's arguments]
OHB_ENDS=1 in the environment: every input and value of humanmaterial too, not some (many minutes).
"""
import json
import os
import re
import shutil
import stat
import struct
import unittest
import uuid
from pathlib import Path

from support import BAD_INPUT, BUG, DONE, TRY_AGAIN, UNDECIDED, Fixture, Programs, run


LONG = "OHB_ENDS" in os.environ


class Places(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.fixture = Fixture()

    @classmethod
    def tearDownClass(cls):
        for folder, _, _ in os.walk(cls.fixture.folder):
            os.chmod(folder, stat.S_IRWXU)
        cls.fixture.remove()

    def place(self):
        place = self.fixture.folder / uuid.uuid4().hex
        place.mkdir()
        return place

    def commands(self, output):
        """Without those that start Blender many times over, and those that write nothing."""
        named = self.fixture.commands(output, heavy=False)
        for name in ("produce dry run", "submit dry run", "status", "verify"):
            del named[name]
        for slow in ("label serve", "label refine", "chart speed-accuracy", "chart stress", "chart bake", "chart bake-stress"):
            del named[slow]
        return named

    def expect_words(self, result, what, codes=(BAD_INPUT,)):
        what = "%s: %d, %s" % (what, result.returncode, result.stderr)
        self.assertIn(result.returncode, codes, what)
        self.assertNotIn("a bug", result.stderr, what)
        if result.returncode not in (DONE, UNDECIDED):    # that verdict stands in the output
            self.assertGreaterEqual(len(result.stderr.splitlines()), 1, what)

    def without_rights(self, words, **options):
        """As a user who may not do everything."""
        if os.geteuid() != 0:
            return run(words, **options)
        if not shutil.which("setpriv"):
            self.skipTest("root without setpriv")
        drop = ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups", "env"]
        import subprocess
        return subprocess.run([*drop, *Programs.command(words)], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, text=True, errors="replace", timeout=300, **options)

    def inputs_of(self, words):
        """The places of words that name an input that is there."""
        return [i for i, word in enumerate(words) if i > 1 and isinstance(word, Path) and word.exists()]

    def test_inputs_that_are_no_files(self):
        place = self.place()
        pipe = place / "pipe.obj"
        os.mkfifo(pipe)
        for name, words in self.commands(place / "out").items():
            for i in self.inputs_of(words):
                bad = [pipe, Path("/dev/zero"), Path("/dev/null"), place / ("n" * 300), place / ("d/" * 3000 + "x"), Path("")]
                if Path(words[i]).is_file():
                    bad.append(self.fixture.folder)
                else:
                    bad.append(self.fixture.scan)
                if not LONG and words[0] == "humanmaterial":    # a second or two each
                    bad = [bad[0], bad[-1]]
                for other in bad:
                    changed = [*words[:i], str(other) if other != Path("") else "", *words[i + 1:]]
                    result = run(changed, timeout=60)
                    self.expect_words(result, "%s with %s as %s" % (name, str(other)[-60:], words[i]))
                    self.assertFalse((place / "out").exists(), name)

    def test_names_that_are_no_utf_8(self):
        place = self.place()
        odd = os.fsencode(place) + b"/\xff\xfe\xe4"
        os.mkdir(odd)
        for entry in ("scan.obj", "scan.mtl", "colour.png", "grey.hdr"):
            shutil.copy(os.fsencode(self.fixture.folder / entry), odd + b"/" + os.fsencode(entry))
        shutil.copy(odd + b"/scan.obj", odd + b"/\xff.obj")
        o = "openhumanbrdf"
        steps = [[o, "inspect", odd + b"/\xff.obj", "--json"],
                 [o, "label", odd + b"/\xff.obj", "-o", odd + b"/regions", "--json"],
                 [o, "bake", odd + b"/\xff.obj", "--regions", odd + b"/regions", "--size", 32, "-o", odd + b"/model", "--json"],
                 [o, "render", odd + b"/model", "--environment", odd + b"/grey.hdr", "--size", 16, "--spp", 1, "-o",
                  odd + b"/samples", "--json"]]
        for step in steps:
            result = run(step)
            self.assertEqual(result.returncode, DONE, result.stderr)
            json.loads(result.stdout)
        # Refused or done, in words.
        result = run([o, "validate", odd + b"/model", "--environment", odd + b"/grey.hdr", "--size", 16, "--spp", 1, "--seeds", 2,
                      "-o", odd + b"/report", "--json"])
        self.expect_words(result, "validate", (DONE, 1, BAD_INPUT, UNDECIDED))
        if Programs.learner:
            for name, words in self.commands(place / "out").items():
                if words[0] == "humanmaterial":
                    output = odd + (b"/%s.png" if name == "relight" else b"/%s") % name.encode()
                    result = run([*words[:-1], output, "--json"])
                    self.expect_words(result, name, (DONE, BAD_INPUT)) if result.returncode else json.loads(result.stdout)

    def test_outputs_that_cannot_be(self):
        place = self.place()
        (place / "file").write_text("mine")
        for name, words in self.commands(place / "out").items():
            if "-o" not in words:
                continue
            suffix = ".png" if name == "relight" else ""
            for bad in (place / ("n" * 300 + suffix), place / ("d/" * 3000 + "x" + suffix), place / "file" / ("x" + suffix),
                        Path("/proc/x" + suffix), Path("/dev/null/x" + suffix)):
                result = run([*words[:-1], bad])
                self.expect_words(result, "%s -o %s" % (name, str(bad)[-60:]))
        self.assertEqual((place / "file").read_text(), "mine")

    def test_no_rights(self):
        place = self.place()
        os.chmod(self.fixture.folder, 0o755)
        closed = place / "closed"
        closed.mkdir()
        shutil.copy(self.fixture.scan, closed / "scan.obj")
        os.chmod(closed, 0)
        unreadable = place / "unreadable.obj"
        shutil.copy(self.fixture.scan, unreadable)
        os.chmod(unreadable, 0)
        for name, words in self.commands(closed / "out").items():
            self.expect_words(self.without_rights(words), name + " into a folder without rights",
                              (DONE,) if name == "inspect" else (BAD_INPUT,))
            for bad in (closed / "scan.obj", unreadable):
                for i in self.inputs_of(words)[:1]:
                    self.expect_words(self.without_rights([*words[:i], bad, *words[i + 1:]]), "%s of %s" % (name, bad.name))

    def test_a_umask_that_takes_the_owners_rights(self):
        place = self.place()
        os.chmod(self.fixture.folder, 0o755)
        os.chmod(place, 0o777)
        words = self.commands(place / "out")["label by names"]
        self.expect_words(self.without_rights(words, preexec_fn=lambda: os.umask(0o777)), "label")
        self.assertEqual(os.listdir(place), [])

    def test_a_working_folder_that_is_gone(self):
        for name, words in self.commands(Path("out")).items():
            gone = self.place()
            program = Programs.command(words)
            import subprocess
            result = subprocess.run(["sh", "-c", 'rmdir "$1" && shift && exec "$@"', "sh", gone, *program], cwd=gone,
                                    stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                    errors="replace", timeout=300)
            self.expect_words(result, name, (DONE, BAD_INPUT)) if result.stderr else self.assertEqual(result.returncode, DONE)

    def test_no_folder_for_temporary_files(self):
        place = self.place()
        (place / "file").write_text("")
        for i, folder in enumerate((place / "none", place / "file", "/proc")):
            for name, words in self.commands(place / ("out%d" % i)).items():
                result = run(words, env={**os.environ, "TMPDIR": str(folder)})
                if result.returncode not in (DONE, 1, 3):
                    self.expect_words(result, "%s with TMPDIR=%s" % (name, folder), (BAD_INPUT, TRY_AGAIN))
                self.assertNotEqual(result.returncode, BUG)

    def damaged(self, text, kinds):
        """Copies of a text in which one value has another type."""
        values = list(re.finditer(r'(?<=": )("[^"]*"|-?[\d.e+-]+|true|false|\[|\{)', text))
        for match in values:
            for other in kinds:
                yield text[:match.start()] + other + text[match.end():]

    def test_headers_with_values_of_other_types(self):
        if not Programs.learner:
            self.skipTest("humanmaterial is not built")
        place = self.place()
        # A weights file: the header within the header, key by key.
        weights = [w for w in self.fixture.estimate(place / "x") if str(w).endswith(".safetensors")]
        data = weights[0].read_bytes()
        length, = struct.unpack("<Q", data[:8])
        header = json.loads(data[8:8 + length])
        inner = json.loads(header["__metadata__"]["humanmaterial"])
        others = ["x", -1, 1e300, None, [], {}, [[1]], True, 2.5]
        for n, key in enumerate(inner):
            for other in others if LONG else [others[(n + k) % len(others)] for k in (0, 4)]:
                changed = {**header, "__metadata__": {"humanmaterial": json.dumps({**inner, key: other})}}
                text = json.dumps(changed).encode()
                file = place / "w.safetensors"
                file.write_bytes(struct.pack("<Q", len(text)) + text + data[8 + length:])
                words = [file if w == weights[0] else w for w in self.fixture.estimate(place / ("o" + uuid.uuid4().hex))]
                result = run(words)
                self.assertNotIn("a bug", result.stderr, "%s = %r: %s" % (key, other, result.stderr))
                self.assertIn(result.returncode, (DONE, BAD_INPUT), "%s = %r: %s" % (key, other, result.stderr))
        # maps.json, value by value.
        maps = self.fixture.folder / "maps"
        text = (maps / "maps.json").read_text()
        copies = list(self.damaged(text, ['"x"', "null", "[[]]"]))
        for i, changed in enumerate(copies[::max(1, len(copies) // (60 if LONG else 4))]):
            folder = place / ("maps%d" % i)
            shutil.copytree(maps, folder)
            (folder / "maps.json").write_text(changed)
            result = run(["humanmaterial", "relight", folder, "--environment", self.fixture.environment, "--size", 8, "--spp", 1,
                          "-o", place / "m.png"])
            self.assertNotIn("a bug", result.stderr, changed)
            self.assertIn(result.returncode, (DONE, BAD_INPUT), result.stderr)


if __name__ == "__main__":
    Programs.take_arguments()
    unittest.main(verbosity=2)
