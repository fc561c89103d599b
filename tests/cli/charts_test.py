"""The charts of openhumanbrdf from outside: files, figures, exit codes.

usage: charts_test.py PROGRAM [unittest's arguments]
"""
import json
import os

from cli_case import Case, DONE, main, run


class Charts(Case):
    def test_chart_of_speed_and_accuracy(self):
        chart = self.folder / "chart"
        arguments = ["chart", "speed-accuracy", self.folder / "model", "--environment", self.environment, "--size", 32,
                     "--max-spp", 16, "--seeds", 8, "-o", chart]
        result = run(*arguments, "--json")
        self.assertEqual(result.returncode, DONE, result.stderr)
        report = json.loads(result.stdout)
        self.assertEqual({p.name for p in chart.iterdir() if not p.name.startswith(".")},
                         {"chart.csv", "chart.gp", "chart.json", "chart.png", "chart.svg"})
        self.assertIn("Cycles, adaptive", (chart / "chart.svg").read_text())
        for series in ("ours", "Cycles"):
            low, high = [p["relative_error"] for p in report["points"] if p["series"] == series]
            # Four times the paths: half the error if they were independent, less if they are stratified. With 8 seeds
            # the ratio is within 15 % of its own mean for these 3000 values.
            self.assertGreater(low / high, 1.6, series)
            self.assertLess(low / high, 6, series)
        self.assertTrue(any(p["on_front"] for p in report["points"]))
        # A relative folder: gnuplot changes into it.
        result = run(*arguments[:-6], "--max-spp", 4, "--seeds", 2, "-o", os.path.relpath(self.folder / "relative"))
        self.assertEqual(result.returncode, DONE, result.stderr)
        self.assertTrue((self.folder / "relative" / "chart.svg").exists())
        self.expect_refusal(run(*arguments[:-1], self.folder / "x", "--blender", "/bin/false"), "/bin/false")
        self.assertFalse((self.folder / "x").exists())

    def test_chart_of_bake(self):
        arguments = ["chart", "bake", self.scan, "--regions", self.folder / "regions", "--environment", self.environment,
                     "--size", 32, "--spp", 8, "--keep-seams"]   # of a picture of 32 px, mended seams are a large part
        result = run(*arguments, "--map-sizes", 64, 32, 4, "--json", "-o", self.folder / "bake_chart")
        self.assertEqual(result.returncode, DONE, result.stdout)
        report = json.loads(result.stdout)
        self.assertEqual([p["map_px"] for p in report["points"]], [64, 32, 4])
        self.assertEqual(report["points"][1]["failures"], [])
        self.assertNotEqual(report["points"][2]["failures"], [])
        self.assertLess(report["points"][1]["relative_error"], report["points"][2]["relative_error"])
        self.assertEqual({p.name for p in (self.folder / "bake_chart").iterdir() if not p.name.startswith(".")},
                         {"chart.csv", "chart.gp", "chart.json", "chart.png", "chart.svg"})
        self.expect_refusal(run(*arguments, "--materials", self.scan, "-o", self.folder / "x"), "scan.obj")
        self.assertFalse((self.folder / "x").exists())

    def test_chart_of_bake_stress(self):
        chart = self.folder / "bake_stress"
        result = run("chart", "bake-stress", "--case", "source far from the target", "-o", chart)
        self.assertEqual(result.returncode, DONE, result.stdout + result.stderr)
        self.assertIn("within its limits", result.stdout)
        self.assertEqual({p.name for p in chart.iterdir() if not p.name.startswith(".")},
                         {"chart.csv", "chart.gp", "chart.json", "chart.png", "chart.svg"})
        self.assertIn("cm away from the scan", (chart / "chart.csv").read_text())
        self.expect_refusal(run("chart", "bake-stress", "--case", "none", "-o", self.folder / "x"), "none")

    def test_chart_of_stress(self):
        catalogue = self.folder / "catalogue.json"
        case = {"name": "tiny", "scene": "roughness", "what": "a ball", "parameter": "roughness", "acceptable": "all",
                "accept": {"cycles": 0.05}, "points": [1, 0.1]}
        catalogue.write_text(json.dumps({"cases": [case]}))
        arguments = ["chart", "stress", "--catalogue", catalogue, "--size", 16, "--spp", 64, "-o"]
        result = run(*arguments, self.folder / "stress", "--json")
        self.assertEqual(result.returncode, DONE, result.stderr)
        points = json.loads(result.stdout)["cases"][0]["points"]
        for point in points:
            self.assertLess(abs(point["ours"]["mean_radiance"] / point["cycles"]["mean_radiance"] - 1), 0.1)
        self.assertEqual({p.name for p in (self.folder / "stress").iterdir() if not p.name.startswith(".")},
                         {"chart.csv", "chart.gp", "chart.json", "chart.png", "chart.svg"})
        self.assertIn("tiny: within its limits", (self.folder / "stress" / "chart.svg").read_text())
        # A limit that it does not keep: charted, and exit code 1.
        case["accept"] = {"first": 0.001}
        catalogue.write_text(json.dumps({"cases": [case]}))
        result = run(*arguments, self.folder / "stress2", "--no-cycles")
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn("NOT WITHIN", result.stdout)
        self.expect_refusal(run(*arguments, self.folder / "x", "--no-cycles", "--case", "none"), "--case none")
        self.expect_refusal(run(*arguments, self.folder / "x", "--blender", "/bin/false"), "/bin/false")
        catalogue.write_text("{")
        self.expect_refusal(run(*arguments, self.folder / "x"), "catalogue.json")
        self.assertFalse((self.folder / "x").exists())


if __name__ == "__main__":
    main()
