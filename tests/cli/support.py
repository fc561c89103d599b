"""What the tests of both programs from outside share: a small person, its model and samples, and running commands."""
import os
import resource
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from small_scene import write_hdr, write_scan

DONE, BAD_INPUT, UNDECIDED, BUG, TRY_AGAIN = 0, 2, 3, 70, 75
ROOT = Path(__file__).resolve().parents[2]


class Programs:
    """openhumanbrdf and, where it is built, humanmaterial, by the paths that ctest gives."""
    ohb = None
    learner = None

    @classmethod
    def take_arguments(cls):
        cls.ohb = os.path.abspath(sys.argv.pop(1))
        if len(sys.argv) > 1 and sys.argv[1].endswith("humanmaterial"):
            cls.learner = os.path.abspath(sys.argv.pop(1))

    @classmethod
    def command(cls, words):
        program = cls.ohb if words[0] == "openhumanbrdf" else cls.learner
        return [program, *map(os.fspath, map(lambda w: w if isinstance(w, (bytes, Path)) else str(w), words[1:]))]


def run(words, memory_limit=None, timeout=300, **options):
    """Runs a command whose first word is the name of its program."""
    def limit():
        if memory_limit is not None:
            resource.setrlimit(resource.RLIMIT_AS, (memory_limit, memory_limit))
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    return subprocess.run(Programs.command(words), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          text=True, errors="replace", timeout=timeout, preexec_fn=limit, **options)


class Fixture:
    """A folder with a scan, regions, a model, an environment and, for humanmaterial, samples and maps."""

    def __init__(self):
        self.folder = Path(tempfile.mkdtemp(prefix="ohb-ends-"))
        f = self.folder
        self.scan, self.environment = write_scan(f), write_hdr(f / "grey.hdr")
        self.must(["openhumanbrdf", "label", self.scan, "-o", f / "regions"])
        self.must(["openhumanbrdf", "bake", self.scan, "--regions", f / "regions", "--size", 64, "-o", f / "model"])
        self.write_plan()
        self.must(["openhumanbrdf", "produce", f / "plan.xml", "-o", f / "dataset"])
        if Programs.learner:
            self.must(["openhumanbrdf", "render", f / "model", "--environment", self.environment, "--size", 64, "--spp", 4,
                       "--views", 2, "-o", f / "samples"])
            self.photo = next((f / "samples" / "previews").glob("view_000.relit.*.png"))
            self.mask = f / "samples" / "previews" / "view_000.mask.png"
            self.must(self.estimate(f / "maps"))

    def estimate(self, output):
        weights = sorted((ROOT / "assets/weights").glob("*.safetensors"))
        return ["humanmaterial", "estimate", self.photo, "--mask", self.mask, "--weights", *weights, "--size", 64, "-o", output]

    def write_plan(self, name="plan.xml", views=1, size=16, spp=1):
        (self.folder / "labels.txt").write_text("0\n0\n0\n0\n2\n2\n")
        (self.folder / "lights").mkdir(exist_ok=True)
        shutil.copy(self.environment, self.folder / "lights")
        (self.folder / name).write_text(
            '<plan schema="1" name="small"><maps size_px="32"/><person id="a" scan="scan.obj" labels="labels.txt" split="train"/>'
            '<environments id="e" folder="lights"/><views split="train" count="%d" size_px="%d" spp="%d">'
            '<lights from="e"/></views></plan>' % (views, size, spp))
        return self.folder / name

    def commands(self, output, heavy):
        """Every command of both programs, writing to `output`. heavy: so much work that it can be stopped midway."""
        f, o = self.folder, "openhumanbrdf"
        person = ROOT / "assets/example_human/example_human.glb" if heavy else self.scan
        light = ["--environment", self.environment]
        labels = ROOT / "assets/example_human/example_human.labels.txt"
        named = {
            "inspect": [o, "inspect", person],
            "label by names": [o, "label", person, "-o", output],
            "label automatic": [o, "label", person, "--automatic", "-o", output],
            "label refine": [o, "label", person, "--automatic", "--refine", "on", "-o", output],
            "label serve": [o, "label", person, "--serve"],
            "bake": [o, "bake", self.scan, "--regions", f / "regions", "--size", 2048 if heavy else 64, "-o", output],
            "render": [o, "render", f / "model", *light, "--size", 512 if heavy else 32, "--spp", 1024 if heavy else 2,
                       "--views", 3 if heavy else 1, "-o", output],
            "environments synthesise": [o, "environments", "synthesise", "--count", 50 if heavy else 1,
                                        "--width", 1024 if heavy else 16, "-o", output],
            "environments import": [o, "environments", "import", self.environment, "--licence", "CC0-1.0",
                                    "--width", 8192 if heavy else 16, "-o", output],
            "validate": [o, "validate", f / "model", *light, "--size", 256 if heavy else 16, "--spp", 512 if heavy else 2,
                         "--seeds", 8 if heavy else 2, "--focus", 1, "-o", output],
            "chart speed-accuracy": [o, "chart", "speed-accuracy", f / "model", *light, "--size", 256 if heavy else 16,
                                     "--max-spp", 1024 if heavy else 4, "--seeds", 2, "-o", output],
            "chart stress": [o, "chart", "stress", "--case", "roughness", "--no-heavy", "--size", 256 if heavy else 8,
                             "--spp", 1024 if heavy else 1, "--seeds", 2, "-o", output],
            "chart bake": [o, "chart", "bake", self.scan, "--regions", f / "regions", *light, "--size", 256 if heavy else 8,
                           "--spp", 1024 if heavy else 1, "--seeds", 2, "--map-sizes", 32, "-o", output],
            "chart bake-stress": [o, "chart", "bake-stress", "--case", "source far from the target", "-o", output],
        }
        plan = self.write_plan("heavy.xml", 9, 512, 1024) if heavy else f / "plan.xml"
        named["produce"] = [o, "produce", plan, "-o", output]
        if not heavy:
            named["produce dry run"] = [o, "produce", plan, "--dry-run"]
            named["submit dry run"] = [o, "submit", plan, "-o", output, "--dry-run"]
            named["status"] = [o, "status", f / "dataset"]
            named["verify"] = [o, "verify", f / "dataset", "--rerender", 1]
        if heavy and not labels.exists():
            del named["label refine"]
        if Programs.learner:
            h = "humanmaterial"
            named["export"] = [o, "export", f / "samples", "--png", "-o", output]
            named.update({
                "train": [h, "train", "geometry", "--data", f / "samples", "--size", 64, "--width", 1 if heavy else 0.05,
                          "--batch", 256 if heavy else 1, "--steps", 50 if heavy else 1, "-o", output],
                "estimate": [*self.estimate(output)[:-4], "--size", 1024 if heavy else 64, "-o", output],
                "torchscript": [h, "torchscript", *self.estimate(output)[5:9], "-o", output],
                "evaluate": [h, "evaluate", *self.estimate(output)[6:9], "--data", f / "samples", "--person", "scan", "--size", 64,
                             *light, "--relight-spp", 4096 if heavy else 1, "-o", output],
                "stress": [h, "stress", *self.estimate(output)[6:9], "--data", f / "samples", "--person", "scan", "--size", 64,
                           "--spp", 4096 if heavy else 1, "-o", output],
                "chart of networks": [h, "chart", ROOT / "assets/weights", "--data", f / "samples", "--person", "scan",
                                      "--size", 64, "-o", output],
                "relight": [h, "relight", f / "maps", *light, "--size", 512 if heavy else 16, "--spp", 4096 if heavy else 1,
                            "-o", output.with_suffix(".png")],
            })
        return named

    def must(self, words):
        result = run(words)
        assert result.returncode == DONE, result.stderr
        return result

    def remove(self):
        shutil.rmtree(self.folder)
