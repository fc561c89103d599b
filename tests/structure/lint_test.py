"""The checks of .clang-tidy over the product's files, newest commits first, for as much processor time as ./test has.

usage: lint_test.py SOURCE_FOLDER BUILD_FOLDER CLANGD [--all [PART_OF_A_PATH...]]

clangd looks at a file alone, not at what it includes, and so takes a third to a tenth of clang-tidy's time; headers are
looked at like other files. Of the checks it leaves out bugprone-use-after-move. Files found clean are remembered in
BUILD_FOLDER/lint until they, a header of the project that they include or .clang-tidy changes: each run goes on where the
last one stopped. --all goes through at once.
"""
import hashlib
import json
import re
import resource
import shlex
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

SECONDS = 15       # of processor time, after which no further file is begun; one takes 1 to 10
FOLDERS = ("bake", "dataset", "renderer", "learner")


def with_headers(root, path, seen):
    """The file and the project's headers that it includes, in a set."""
    if path not in seen and path.is_file():
        seen.add(path)
        for name in re.findall(rb'^#include "([^"]+)"', path.read_bytes(), re.M):
            with_headers(root, root / name.decode(), seen)
    return seen


def newest_first(root, files):
    """Uncommitted files, then those of the last commits, then the rest; in their order where there is no git."""
    place = {}
    if shutil.which("git") is None:
        return files
    for words in (["diff", "--name-only", "HEAD"], ["log", "-n", "100", "--name-only", "--format="]):
        told = subprocess.run(["git", "-C", str(root)] + words, capture_output=True, text=True, check=False).stdout
        for name in told.splitlines():
            place.setdefault(root / name, len(place))
    return sorted(files, key=lambda path: place.get(path, len(place)))


def compile_commands(root, build):
    """The arguments of each source file; a header has those of a file beside it, of its own name where there is one."""
    found = {}
    for entry in json.loads((build / "compile_commands.json").read_text(encoding="utf-8")):
        path = Path(entry["file"]).resolve()
        if path.is_relative_to(root) and path.relative_to(root).parts[0] in FOLDERS:
            found[path] = [word for word in shlex.split(entry["command"]) if not word.endswith("ccache")]
    for folder in sorted({path.parent for path in found}):
        beside = sorted(path for path in found if path.parent == folder)
        for header in sorted(folder.glob("*.h")):
            like = header.with_suffix(".cpp") if header.with_suffix(".cpp") in found else beside[0]
            found[header] = [word.replace(str(like), str(header)) for word in found[like]]
            found[header].insert(1, "-xc++-header")
    return found


class Lint:
    def __init__(self, root, build, program):
        self.root, self.program, self.known = root, program, build / "lint"
        self.known.mkdir(exist_ok=True)
        commands = compile_commands(root, build)
        (self.known / "compile_commands.json").write_text(json.dumps(
            [{"directory": str(build), "file": str(path), "arguments": words} for path, words in commands.items()]))
        self.files = newest_first(root, sorted(commands))

    def mark(self, path):
        """The file that says that this state of a source file is clean."""
        state = hashlib.sha256((self.root / ".clang-tidy").read_bytes())
        for file in sorted(with_headers(self.root, path, set())):
            state.update(str(file.relative_to(self.root)).encode() + file.read_bytes())
        return self.known / state.hexdigest()

    def findings(self, path):
        """What clangd says of a file, nothing where it is known as clean."""
        mark = self.mark(path)
        if mark.exists():
            return ""
        done = subprocess.run([self.program, "--check=" + str(path), "--check-lines=1-1", "--log=error", "--enable-config=false",
                               "--compile-commands-dir=" + str(self.known)], capture_output=True, text=True, check=False)
        if done.returncode == 0:
            mark.touch()
            return ""
        return "\n".join("%s: %s" % (path.relative_to(self.root), re.sub(r"^E\[[\d:.]*\] ", "", line))
                         for line in (done.stderr or "clangd ended with %d" % done.returncode).splitlines())

    def check(self, seconds):
        """(file, findings) of each file until the time is over."""
        def used():
            return sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2])
        end = used() + seconds
        for path in self.files:
            if used() > end:
                break
            yield path, self.findings(path)


class Checks(unittest.TestCase):
    def test_the_newest_files_are_clean(self):
        found = list(LINT.check(SECONDS))
        wrong = [text for _, text in found if text]
        print("%d of %d files are known as clean" % (len(found) - len(wrong), len(LINT.files)))
        self.assertTrue(found)
        self.assertFalse(wrong, "\n" + "\n".join(wrong))

    def test_planted_mistakes_are_found(self):
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder).resolve()
            (root / ".clang-tidy").write_bytes((LINT.root / ".clang-tidy").read_bytes())
            (root / "bake").mkdir()
            file, header = root / "bake" / "a.cpp", root / "bake" / "a.h"
            command = {"directory": folder, "file": str(file), "command": "c++ -I%s -c %s" % (folder, file)}
            (root / "compile_commands.json").write_text(json.dumps([command]))
            file.write_text('#include "bake/a.h"\nint twice(int a) { return sum(a, a); }\n')
            header.write_text("#pragma once\ninline int sum(int a, int b) { return a + b; }\n")
            lint = Lint(root, root, LINT.program)
            self.assertEqual([lint.findings(path) for path in (file, header)], ["", ""])
            self.assertTrue(lint.mark(file).exists())
            header.write_text("#pragma once\ninline int sum(int a, int b) { return a > b && a > b ? a : b; }\n")
            self.assertFalse(lint.mark(file).exists())
            self.assertEqual(lint.findings(file), "")
            self.assertIn("bake/a.h: [misc-redundant-expression] Line 2", lint.findings(header))


if __name__ == "__main__":
    LINT = Lint(Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve(), sys.argv[3])
    if "--all" in sys.argv:
        parts = sys.argv[5:]
        LINT.files = [path for path in LINT.files if not parts or any(part in str(path) for part in parts)]
        bad = [print(text, flush=True) for _, text in LINT.check(float("inf")) if text]
        sys.exit("%d of %d files have findings" % (len(bad), len(LINT.files)) if bad else 0)
    unittest.main(argv=[sys.argv[0], "-v"])
