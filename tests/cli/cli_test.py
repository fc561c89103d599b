"""The program openhumanbrdf from outside: exit codes, messages, equal bytes, full disks.

usage: cli_test.py PROGRAM [unittest's arguments]
"""
import json
import shutil
import subprocess

from cli_case import Case, DONE, Program, TRY_AGAIN, digest, main, run
from small_scene import write_hdr


class Commands(Case):
    def test_every_command_has_help_with_examples(self):
        overview = run("--help")
        self.assertEqual(overview.returncode, DONE)
        for command in ("inspect", "label", "bake", "render", "validate", "chart speed-accuracy", "chart stress", "chart bake", "chart bake-stress"):
            self.assertIn(command.split()[0], overview.stdout)
            result = run(*command.split(), "--help")
            self.assertEqual(result.returncode, DONE)
            self.assertGreaterEqual(result.stdout.count("openhumanbrdf " + command), 2, command)

    def test_version_names_libraries(self):
        result = run("--version")
        self.assertEqual(result.returncode, DONE)
        for word in ("openhumanbrdf", "OpenImageIO", "Embree"):
            self.assertIn(word, result.stdout)

    def test_same_bytes_for_any_thread_count_and_run(self):
        results = []
        for i, threads in enumerate((1, 2, 8, 8)):
            model, samples = self.folder / ("model%d" % i), self.folder / ("samples%d" % i)
            baked = run("bake", self.scan, "--regions", self.folder / "regions", "--size", 64, "--threads", threads, "-o", model)
            self.assertEqual(baked.returncode, DONE, baked.stderr)
            self.assertEqual(self.render(samples, "--threads", threads).returncode, DONE)
            results.append((digest(model), digest(samples)))
        self.assertGreater(len(results[0][1]), 2)
        for other in results[1:]:
            self.assertEqual(results[0], other)

    def test_full_disk_is_try_again(self):
        # A file-size limit fails writes as a full disk does: in the middle of a file.
        for limit in (0, 4096):
            result = run("bake", self.scan, "--regions", self.folder / "regions", "--size", 512, "-o", self.folder / "full",
                         file_size_limit=limit)
            self.assertEqual(result.returncode, TRY_AGAIN, result.stderr)
            self.assertFalse((self.folder / "full").exists())
            result = self.render(self.folder / "full_samples", file_size_limit=limit)
            self.assertEqual(result.returncode, TRY_AGAIN, result.stderr)
            self.assertFalse((self.folder / "full_samples" / "view_000.exr").exists())
        self.assertEqual(self.leftovers(), [])

    def test_bad_usage(self):
        self.expect_refusal(run("render"), "MODEL")
        self.expect_refusal(run("rendre"), "rendre")
        for option, value, *words in (("--spp", "many", "--spp"), ("--size", "0", "--size"),
                                      ("--views", "4:7", "--views 4:7", "0 <= i < N"),
                                      ("--views", "none", "--views none"), ("--point", "1,2,3", "--point", "x,y,z,I")):
            result = run("render", self.folder / "model", "--environment", self.environment, option, value, "-o",
                         self.folder / "x")
            self.expect_refusal(result, *words)
        self.expect_refusal(run("render", self.folder / "model", "-o", self.folder / "x"), "no light", "--environment")
        self.assertFalse((self.folder / "x").exists())

    def test_bad_paths(self):
        nowhere = self.folder / "nowhere"
        self.expect_refusal(run("inspect", nowhere), "nowhere", "no such file")
        self.expect_refusal(run("label", nowhere, "-o", self.folder / "x"), "nowhere")
        self.expect_refusal(run("render", nowhere, "--environment", self.environment, "-o", self.folder / "x"), "nowhere")
        self.expect_refusal(run("render", self.folder / "model", "--environment", nowhere, "-o", self.folder / "x"), "nowhere")
        self.expect_refusal(self.render("/dev/null/x"), "/dev/null/x")
        self.expect_refusal(run("label", self.scan, "-o", "/dev/null/x"), "/dev/null")
        self.expect_refusal(run("label", self.scan, "-o", self.scan), "is a file")
        self.assertFalse((self.folder / "x").exists())

    def test_never_replaces_a_folder_of_the_users(self):
        mine = self.folder / "mine"
        mine.mkdir()
        (mine / "thesis.tex").write_text("years of work")
        self.expect_refusal(run("label", self.scan, "-o", mine), "was not written by this program")
        self.assertEqual((mine / "thesis.tex").read_text(), "years of work")

    def test_replaces_only_its_like(self):
        model, regions = self.folder / "kinds_model", self.folder / "kinds_regions"
        shutil.copytree(self.folder / "regions", regions)
        bake = ["bake", self.scan, "--size", 32, "--regions", self.folder / "regions", "-o"]
        self.assertEqual(run(*bake, model).returncode, DONE)
        before = digest(model)
        self.expect_refusal(run("label", self.scan, "-o", model), "holds model", "regions would be", "another -o")
        self.expect_refusal(run("bake", self.scan, "--regions", regions, "-o", regions), "holds regions")
        self.expect_refusal(run("label", self.scan, "--faces", regions / "faces.txt", "-o", regions), "faces.txt",
                            "which this command reads")
        (model / "notes.txt").write_text("texels to look at again")
        self.expect_refusal(run(*bake, model), "'notes.txt'", "move what you want to keep")
        (model / "notes.txt").unlink()
        self.assertEqual(digest(model), before)
        # A link is followed, and stays.
        (self.folder / "kinds_link").symlink_to("kinds_model", target_is_directory=True)
        self.assertEqual(run(*bake, self.folder / "kinds_link").returncode, DONE)
        self.assertTrue((self.folder / "kinds_link").is_symlink())
        self.assertEqual(digest(model), before)
        self.assertEqual(self.leftovers(), [])

    def test_bad_environments(self):
        cases = {"black.hdr": ((16, 8, (0, 0, 0, 0)), "all black"), "square.hdr": ((8, 8, (128, 128, 128, 129)), "2:1")}
        for name, (arguments, words) in cases.items():
            file = write_hdr(self.folder / name, *arguments)
            self.expect_refusal(run("render", self.folder / "model", "--environment", file, "-o", self.folder / "x"), name, words)
        twin = self.folder / "twin"
        twin.mkdir()
        shutil.copyfile(self.environment, twin / "grey.hdr")
        self.expect_refusal(self.render(self.folder / "x", "--environment", twin / "grey.hdr"), "grey", "rename")
        self.assertFalse((self.folder / "x").exists())

    def test_broken_models(self):
        def broken(name, change):
            copy = self.folder / name
            shutil.copytree(self.folder / "model", copy)
            change(copy)
            return run("render", copy, "--environment", self.environment, "-o", self.folder / "x")
        a_map = next((self.folder / "model" / "maps").rglob("albedo.exr")).relative_to(self.folder / "model")
        self.expect_refusal(broken("m1", lambda m: (m / "model.xml").unlink()), "model.xml")
        self.expect_refusal(broken("m2", lambda m: (m / "model.xml").write_text("<model")), "model.xml")
        self.expect_refusal(broken("m3", lambda m: (m / a_map).unlink()), "albedo.exr")
        self.expect_refusal(broken("m4", lambda m: (m / a_map).write_bytes(b"")), "albedo.exr", "empty")
        self.expect_refusal(broken("m5", lambda m: (m / a_map).write_bytes((m / a_map).read_bytes()[:200])), "albedo.exr")
        self.expect_refusal(broken("m6", lambda m: (m / "mesh.obj").write_text("v 1 2 nan\n")), "mesh.obj")
        self.expect_refusal(broken("m7", lambda m: (m / "faces.bin").write_bytes(b"abc")), "faces.bin")

    def test_results_that_nobody_gets_are_no_success(self):
        for arguments in (["inspect", self.scan, "--json"], ["inspect", self.scan], ["--help"], ["--version"],
                          ["label", self.scan, "-o", self.folder / "unheard"]):
            with open("/dev/full", "w") as full:
                result = subprocess.run([Program.path, *map(str, arguments)], stdout=full, stderr=subprocess.PIPE, text=True)
            self.assertEqual(result.returncode, TRY_AGAIN, arguments)
            self.assertIn("results could not be written", result.stderr)

    def test_json_is_one_object_on_stdout(self):
        for arguments in (["inspect", self.scan], ["label", self.scan, "-o", self.folder / "j1"],
                          ["bake", self.scan, "--regions", self.folder / "regions", "--size", 32, "-o", self.folder / "j2"]):
            result = run(*arguments, "--json")
            self.assertEqual(result.returncode, DONE, result.stderr)
            self.assertIsInstance(json.loads(result.stdout), dict)


if __name__ == "__main__":
    main()
