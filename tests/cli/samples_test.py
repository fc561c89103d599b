"""The samples that render writes: settings kept apart, interruption, error goals, quality.

usage: samples_test.py PROGRAM [unittest's arguments]
"""
import json
import shutil
import signal
import subprocess
import time
from pathlib import Path

from cli_case import Case, DONE, Program, TRY_AGAIN, digest, main, run
from small_scene import write_hdr


class Samples(Case):
    def test_resumes_without_rendering_again(self):
        output = self.folder / "resumed"
        self.assertEqual(self.render(output).returncode, DONE)
        before = digest(output)
        (output / "view_001.exr").unlink()
        result = self.render(output, "--json")
        self.assertEqual([v["was_there"] for v in json.loads(result.stdout)["views"]], [True, False])
        self.assertEqual(digest(output), before)
        # A truncated view is not a finished one.
        data = (output / "view_000.exr").read_bytes()
        (output / "view_000.exr").write_bytes(data[:len(data) // 2])
        self.assertEqual(self.render(output).returncode, DONE)
        self.assertEqual(digest(output), before)

    def test_samples_of_other_settings_are_refused(self):
        samples, model = self.folder / "settings", self.folder / "settings_model"
        labels = self.folder / "other.labels.txt"
        labels.write_text("3\n" * 6)
        bake = ["bake", self.scan, "--size", 32, "-o", model, "--regions"]
        self.assertEqual(run(*bake, self.folder / "regions").returncode, DONE)
        common = ["--environment", self.environment, "--size", 32, "--spp", 4, "--views", "4:0,1", "-o", samples]

        def render(*more, of=model):
            given = [a for i, a in enumerate(common) if common[2 * (i // 2)] not in more]
            return run("render", of, *given, *more)
        self.assertEqual(render().returncode, DONE)
        before = digest(samples)
        # What is asked for.
        for more, word in ((["--size", 16], "size_px is '32' there and '16' now"), (["--spp", 8], "spp is '4'"),
                           (["--views", "2"], "viewCount is '4'"), (["--seed", 2], "seed"),
                           (["--subsurface", "diffuse"], "subsurface"), (["--model", "v2"], "shadingModel is not set"),
                           (["--quality", "fast"], "quality"), (["--bounces", 2], "maxBounces"), (["--sampling", "even"], "sampling"),
                           (["--point", "100,200,300,5"], "point.point0 is not set there")):
            self.expect_refusal(render(*map(str, more)), "settings", word, "--overwrite", "another -o")
        # Lights.
        (self.folder / "brighter").mkdir()
        brighter = write_hdr(self.folder / "brighter" / "grey.hdr", value=(128, 128, 128, 131))
        self.expect_refusal(render("--environment", brighter), "environment.grey is another picture")
        other = write_hdr(self.folder / "white.hdr")
        self.expect_refusal(render("--environment", other), "environment.white was not among the lights")
        # The model, baked again by other labels, materials, sizes; and another person.
        table = self.folder / "other_materials.xml"
        table.write_text((Path(__file__).parents[2] / "assets" / "materials.xml").read_text().replace('roughness=".400"', 'roughness=".41"')
                         .replace('roughness="0.400"', 'roughness="0.41"'))
        regions = self.folder / "other_regions"
        self.assertEqual(run("label", self.scan, "--faces", labels, "-o", regions).returncode, DONE)
        for changed in (["--regions", regions], ["--regions", self.folder / "regions", "--materials", table],
                        ["--regions", self.folder / "regions", "--size", 64]):
            given = ["bake", self.scan, *([] if "--size" in changed else ["--size", 32]), "-o", model, *changed]
            baked = run(*given)
            self.assertEqual(baked.returncode, DONE, baked.stderr)
            self.expect_refusal(render(), "the model is another one, or was baked again")
        self.assertEqual(run(*bake, self.folder / "regions", "--name", "bob").returncode, DONE)
        self.expect_refusal(render(), "human is 'scan' there and 'bob' now")
        # One texel, by hand.
        self.assertEqual(run(*bake, self.folder / "regions").returncode, DONE)
        albedo = sorted((model / "maps").rglob("albedo.exr"))
        shutil.copyfile(albedo[1], albedo[0]) if albedo[0].read_bytes() != albedo[1].read_bytes() else None
        self.expect_refusal(render(), "the model is another one")
        self.assertEqual(run(*bake, self.folder / "regions").returncode, DONE)
        self.assertEqual(digest(samples), before)
        # The same again: nothing to do. More views of the same: added.
        self.assertIn("0 views rendered, 2 were there", render().stdout)
        more = render("--views", "4:2,3")
        self.assertIn("2 views rendered", more.stdout, more.stderr)
        self.assertEqual([v["view"] for v in json.loads((samples / "render.json").read_text())["views"]], [0, 1, 2, 3])
        whole = {**digest(samples), **before}
        self.assertEqual(digest(samples), whole)
        # Replaced on request, all of it: no view of the old settings stays.
        self.assertEqual(render("--views", "2", "--overwrite").returncode, DONE)
        self.assertEqual(sorted(p.name for p in samples.glob("view_*")), ["view_000.exr", "view_001.exr"])
        self.assertEqual({p.name.split(".")[0] for p in (samples / "previews").iterdir()}, {"view_000", "view_001"})
        self.assertIn("0 views rendered", render("--views", "2", "--overwrite").stdout)

    def test_samples_go_where_they_belong(self):
        model = self.folder / "samples_model"
        shutil.copytree(self.folder / "model", model)
        self.expect_refusal(self.render(model), "holds model", "samples would be")
        # Views of which nothing is known, and a file of that name that is no view of this job.
        unknown = self.folder / "unknown"
        unknown.mkdir()
        (unknown / "view_000.exr").write_text("somebody's")
        self.expect_refusal(self.render(unknown), "holds 'view_000.exr'", "not written by this program")
        self.assertEqual([p.name for p in unknown.iterdir()], ["view_000.exr"])
        (unknown / ".openhumanbrdf").write_text("kind samples\n")
        self.expect_refusal(self.render(unknown), "view_000.exr", "nothing says by which settings", "--overwrite")
        self.assertEqual((unknown / "view_000.exr").read_text(), "somebody's")
        samples = self.folder / "with_a_stray"
        self.assertEqual(self.render(samples).returncode, DONE)
        shutil.copyfile(samples / "view_000.exr", samples / "view_002.exr")
        three = ["render", self.folder / "model", "--environment", self.environment, "--size", 48, "--spp", 8, "-o", samples]
        self.expect_refusal(run(*three, "--views", "4:2"), "view_002.exr", "no job of this folder wrote it")
        self.assertEqual(run(*three, "--views", "4:2", "--overwrite").returncode, DONE)
        self.assertNotEqual((samples / "view_000.exr").read_bytes(), (samples / "view_002.exr").read_bytes())
        # A bake over the samples' folder, or over a model with samples in it.
        bake = ["bake", self.scan, "--regions", self.folder / "regions", "--size", 64, "-o"]
        self.expect_refusal(run(*bake, samples), "holds samples")
        self.assertEqual(self.render(model / "samples").returncode, DONE)
        self.expect_refusal(run(*bake, model), "samples/")

    def test_a_killed_job_goes_on_whatever_was_listed(self):
        samples = self.folder / "killed"
        self.assertEqual(self.render(samples).returncode, DONE)
        before, listing = digest(samples), json.loads((samples / "render.json").read_text())
        # Killed between a view and its line.
        listing["views"] = listing["views"][:1]
        (samples / "render.json").write_text(json.dumps(listing))
        self.assertIn("0 views rendered, 2 were there", self.render(samples).stdout)
        self.assertEqual(digest(samples), before)
        self.assertEqual(len(json.loads((samples / "render.json").read_text())["views"]), 2)
        (samples / "render.json").write_text("{")
        self.expect_refusal(self.render(samples), "render.json", "not well-formed")

    def test_error_goal(self):
        arguments = ["render", self.folder / "model", "--environment", self.environment, "--size", 48, "--json", "-o"]
        result = run(*arguments, self.folder / "goal", "--error", 0.05)
        self.assertEqual(result.returncode, DONE, result.stderr)
        error = json.loads(result.stdout)["views"][0]["error"]
        self.assertTrue(error["met"])
        self.assertEqual({row["region"] for row in error["reached"]} & {"subject"}, {"subject"})
        self.assertTrue(all(row["relative_error"] < 0.06 for row in error["reached"]))
        before = digest(self.folder / "goal")
        again = json.loads(run(*arguments, self.folder / "goal", "--error", 0.05).stdout)
        self.assertTrue(again["views"][0]["was_there"])
        result = run(*arguments, self.folder / "goal2", "--error", 0.05, "--threads", 1)
        self.assertEqual(digest(self.folder / "goal2"), before)
        # Too few paths for it: written, with a warning that names what was reached.
        result = run(*arguments, self.folder / "short", "--error", 0.001, "--max-spp", 32)
        self.assertEqual(result.returncode, DONE, result.stderr)
        self.assertIn("times the goal of 0.001", result.stderr)
        self.assertFalse(json.loads(result.stdout)["views"][0]["error"]["met"])
        self.expect_refusal(run(*arguments, self.folder / "x", "--error", 0.1, "--spp", 4), "--spp", "--error")
        for value in ("0", "-1", "2", "nan", "much"):
            self.expect_refusal(run(*arguments, self.folder / "x", "--error", value), "--error")
        self.expect_refusal(run(*arguments, self.folder / "x", "--max-spp", 64), "--error")
        self.assertFalse((self.folder / "x").exists())

    def test_quality(self):
        def rendered(name, *more):
            result = run("render", self.folder / "model", "--environment", self.environment, "--size", 32, "--spp", 128,
                         "--views", 40, "--json", "-o", self.folder / name, *more)
            self.assertEqual(result.returncode, DONE, result.stderr)
            return json.loads(result.stdout), result.stderr
        report, words = rendered("auto", "--quality", "auto", "--tolerance", 0.05)
        quality = report["quality"]
        self.assertLessEqual(quality["error_at_most"], 0.05)
        self.assertTrue(any(row["left_out"] for row in quality["tried"]), quality)
        for row in quality["tried"]:
            self.assertIn(row["what"], words)
            if row["left_out"]:
                self.assertLessEqual(row["high"], 0.05)
        before = digest(self.folder / "auto")
        (self.folder / "auto" / "view_003.exr").unlink()
        again, _ = rendered("auto", "--quality", "auto", "--tolerance", 0.05)
        self.assertEqual([v["view"] for v in again["views"] if not v["was_there"]], [3])
        self.assertEqual(digest(self.folder / "auto"), before)
        report, _ = rendered("fast", "--quality", "fast")
        self.assertEqual((report["quality"]["subsurface"], report["quality"]["max_bounces"]), (False, 1))
        for arguments in (("--tolerance", 0.1), ("--quality", "auto", "--tolerance", "nan"), ("--quality", "best"),
                          ("--quality", "fast", "--tolerance", 0.1)):
            self.expect_refusal(run("render", self.folder / "model", "--environment", self.environment, *arguments, "-o",
                                    self.folder / "x"), arguments[-2])
        self.assertFalse((self.folder / "x").exists())

    def test_stops_on_sigterm_and_goes_on(self):
        output = self.folder / "stopped"
        arguments = ["render", self.folder / "model", "--environment", self.environment, "--size", 64, "--spp", 512,
                     "--views", "6", "-o", output]
        process = subprocess.Popen([Program.path, *map(str, arguments)], stderr=subprocess.PIPE, text=True)
        while process.poll() is None and not (output / "view_000.exr").exists():
            time.sleep(0.02)
        process.send_signal(signal.SIGTERM)
        _, words = process.communicate(timeout=60)
        self.assertEqual(process.returncode, TRY_AGAIN, words)
        self.assertIn("run the same command again", words)
        self.assertFalse((output / "view_005.exr").exists())
        self.assertEqual([p for p in output.rglob("*") if ".tmp" in p.name], [])


if __name__ == "__main__":
    main()
