"""The files in containers/ do what README.md prints and tests/bare_machine.sh tries on bare systems, in a syntax that holds.

usage: containers_test.py SOURCE_FOLDER [unittest's arguments]
"""
import re
import subprocess
import sys
import unittest
from pathlib import Path

ROOT = Path(sys.argv.pop(1)).resolve() if len(sys.argv) > 1 else Path(__file__).resolve().parents[2]


def docker_stages(text):
    """(base, instructions) of each stage; an instruction is its word and its text, continued lines joined."""
    stages = []
    lines = re.sub(r"^#.*\n", "", text, flags=re.M).replace("\\\n", " ").splitlines()
    for word, rest in (line.split(maxsplit=1) for line in lines if line.strip()):
        if word == "FROM":
            stages.append((rest.split()[0], []))
        else:
            stages[-1][1].append((word, rest))
    return stages


def apptainer_stages(text):
    """(headers, sections) of each stage."""
    stages, section = [], None
    for line in re.sub(r"^#.*\n", "", text, flags=re.M).splitlines():
        header = re.match(r"(\w+): (.*)", line)
        if header and header[1] == "Bootstrap":
            stages.append(({}, {}))
            section = None
        if line.startswith("%"):
            section = line[1:]
            stages[-1][1][section] = ""
        elif section:
            stages[-1][1][section] += line + "\n"
        elif header:
            stages[-1][0][header[1]] = header[2]
    return stages


def packages(shell):
    """What a step installs besides the project's package."""
    words = re.search(r"apt-get install ([^&\n]*)", shell)[1].split()
    return sorted(w for w in words if not w.startswith("-") and "openhumanbrdf_" not in w)


class Containers(unittest.TestCase):
    docker = docker_stages((ROOT / "containers/Dockerfile").read_text())
    apptainer = apptainer_stages((ROOT / "containers/openhumanbrdf.def").read_text())

    def steps(self):
        """(building, installing) of both files, as shell text."""
        runs = [" ; ".join(text for word, text in stage[1] if word == "RUN") for stage in self.docker]
        posts = [sections["post"] for _, sections in self.apptainer]
        return [runs, posts]

    def test_two_bare_systems_of_the_same_debian(self):
        self.assertEqual([base for base, _ in self.docker], ["debian:12"] * 2)
        self.assertEqual([h for h, _ in self.apptainer],
                         [{"Bootstrap": "docker", "From": "debian:12", "Stage": stage} for stage in ("build", "final")])
        self.assertIn("bookworm", (ROOT / "tests/bare_machine.sh").read_text())

    def test_the_same_steps_as_on_the_bare_machines(self):
        readme = (ROOT / "README.md").read_text()
        wanted = packages(readme.split("## Installing a package")[1])
        tried = (ROOT / "tests/bare_machine.sh").read_text()
        self.assertIn("./package", tried)
        self.assertIn('printed "Installing a package"', tried)
        for build, install in self.steps():
            self.assertIn("./package", build)
            self.assertIn("apt-get update", install)
            self.assertIn("--no-install-recommends", install)
            self.assertIn("openhumanbrdf_*_amd64.deb", install)
            self.assertEqual(packages(install), wanted)

    def test_the_shell_can_read_them(self):
        scripts = [text for steps in self.steps() for text in steps]
        scripts += [sections[name] for _, sections in self.apptainer for name in ("test", "runscript") if name in sections]
        self.assertEqual(len(scripts), 6)
        for script in scripts:
            result = subprocess.run(["sh", "-n"], input=script, text=True, stderr=subprocess.PIPE)
            self.assertEqual(result.stderr, "", script)

    def test_what_is_copied(self):
        copies = [text.split() for _, instructions in self.docker for word, text in instructions if word == "COPY"]
        self.assertEqual(copies, [[".", "/src"], ["--from=build", "/src/build/package", "/opt/package"]])
        self.assertEqual(self.apptainer[0][1]["files"].split(), [".", "/src"])
        self.assertEqual(self.apptainer[1][1]["files from build"].split(), ["/src/build/package", "/opt/package"])
        # A build folder of this machine would stop CMake on another one.
        ignored = (ROOT / "containers/Dockerfile.dockerignore").read_text().split()
        for name in ("build", "out"):
            self.assertIn("/%s/" % name, (ROOT / ".gitignore").read_text().split())
            self.assertIn(name, ignored)
            self.assertRegex(self.apptainer[0][1]["post"], r"rm -rf .*\b%s\b" % name)


if __name__ == "__main__":
    unittest.main(verbosity=2)
