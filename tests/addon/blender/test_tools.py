"""The panels Bake, Produce and Validate: their commands, progress, cancel, words, and what they bring into the scene."""
import json
import os
import sys
import time
import unittest.mock

import bpy
from support import ROOT, label_program, scene as s

from human_material.services import baked, jobs, programs, tools
from human_material.services.errors import InputError
from human_material.ui import job_loop, label_loop
from test_label import program
from test_label_faults import state

EXAMPLE = os.path.join(ROOT, "assets", "example_human", "example_human")
STUDIO = os.path.join(ROOT, "assets", "environments", "studio.exr")


class Tools(s.Registered):
    """With the real program: one person from regions to the verdict."""

    def test_bake_show_and_compare(self):
        folder = s.folder()
        regions = os.path.join(folder, "regions")
        run = programs.Run([program(), "label", EXAMPLE + ".glb", "--faces", EXAMPLE + ".labels.txt", "--classes",
                            "skin,hair,fabric,leather", "-o", regions])
        run.wait()
        run.result()
        settings = self.scene.hm.tools
        settings.scan, settings.regions, settings.size_px = EXAMPLE + ".glb", regions, 64
        settings.model = os.path.join(folder, "model")
        bpy.ops.hm.bake()
        self.assertEqual(job_loop.last_words["bake"], "Baked model")
        self.expect_model(settings)
        if bpy.app.version[:2] == (3, 4):
            self.compare(settings)

    def expect_model(self, settings):
        """The model stands in metres with the maps that bake wrote, as they mean."""
        bpy.ops.hm.show_model()
        item = bpy.context.object
        bpy.context.view_layer.update()
        places = [item.matrix_world @ v.co for v in item.data.vertices]
        height = max(p.z for p in places) - min(p.z for p in places)
        self.assertTrue(1.4 < height < 2.1, height)
        self.assertAlmostEqual(min(p.z for p in places), 0, 3)
        tree = item.data.materials[0].node_tree
        images = {os.path.basename(n.image.filepath): n.image for n in tree.nodes if n.type == "TEX_IMAGE"}
        self.assertEqual(set(images) & {"albedo.exr", "roughness.exr", "specular.exr", "sss.exr"},
                         {"albedo.exr", "roughness.exr", "specular.exr", "sss.exr"})
        self.assertEqual(tuple(images["albedo.exr"].size), (64, 64))
        self.assertEqual(images["roughness.exr"].colorspace_settings.name, "Non-Color")
        pixels = list(images["roughness.exr"].pixels)   # the classes' own values, and mixtures
        self.assertTrue(all(0.24 < value < 0.86 for value in pixels[::4]))
        shader = next(n for n in tree.nodes if n.type == "BSDF_PRINCIPLED")
        linked = {link.to_socket.name for link in tree.links if link.to_node == shader}
        self.assertLessEqual({"Base Color", "Roughness"}, linked)

    def compare(self, settings):
        """Too few pictures to decide; the report, its page and Cycles' scene are there."""
        settings.environment, settings.view_px, settings.spp, settings.seeds = STUDIO, 16, 1, 2
        settings.turn_deg, settings.blender = 90, bpy.app.binary_path
        bpy.ops.hm.validate()
        words = job_loop.last_words["validate"]
        self.assertRegex(words, "^(Undecided|Difference|Pass): ")
        report = settings.model + ".report"
        with open(os.path.join(report, "validate.json"), encoding="utf-8") as file:
            self.assertTrue(words.endswith(json.load(file)["sentence"]))
        for name in ("index.html", "scene.blend"):
            self.assertTrue(os.path.isfile(os.path.join(report, name)))
        with bpy.data.libraries.load(os.path.join(report, "scene.blend")) as (inside, _):
            self.assertEqual((sorted(inside.objects), inside.cameras), (["camera", "model"], ["camera"]))
        with unittest.mock.patch("subprocess.Popen") as opened:
            bpy.ops.hm.open_cycles_scene()
        self.assertEqual(opened.call_args.args[0], [bpy.app.binary_path, os.path.join(report, "scene.blend")])


PROGRAM = """#!{python}
import os, signal, sys, time
fault = {fault!r}
def die(words, code=2):
    print(words, file=sys.stderr, flush=True)
    sys.exit(code)
signal.signal(signal.SIGTERM, lambda *_: die("stopped by a signal; run it again", 75))
if fault in ("bar", "hang"):
    for k in range(1, 4 if fault == "bar" else 10 ** 6):
        sys.stderr.write("\\rbaking [###.......] %3d %%  9 s left   " % min(10 * k, 30))
        sys.stderr.flush()
        time.sleep(0.02)
if fault == "chatter":
    sys.stderr.write("x" * 300000 + "\\n")
if fault == "refuse":
    die("scan.obj: line 3: index out of range; export it again")
if fault == "full":
    die("out: the disk is full; free some space and run the command again", 75)
if fault == "crash":
    os.abort()
if fault == "silent":
    sys.exit(2)
if fault == "given up":
    print("2 sets of 1 people made\\ngave up 1 person")
    sys.exit(1)
if fault == "page":
    out = sys.argv[sys.argv.index("-o") + 1]
    os.makedirs(out)
    open(out + "/contact_sheet.png", "wb").write({sheet!r})
    open(out + "/index.html", "w").close()
print("done")
"""


class ToolFaults(s.Registered):
    """What goes wrong beside the panels ends in words; the scene stays as it was."""

    def setUp(self):
        super().setUp()
        bpy.ops.mesh.primitive_monkey_add(location=(3, 1, 2))
        bpy.ops.object.light_add(type="SUN")
        self.folder = s.folder()
        patch = unittest.mock.patch.dict(os.environ, {"HM_TOOLS": self.folder})
        patch.start()
        self.addCleanup(patch.stop)
        self.addCleanup(job_loop.last_words.clear)
        for name in ("scan.obj", "plan.xml", "light.exr"):
            with open(os.path.join(self.folder, name), "w", encoding="ascii") as file:
                file.write("a")
        for name in ("regions", "model", "dataset"):
            os.mkdir(os.path.join(self.folder, name))
        self.settings = self.scene.hm.tools
        for field, name in (("scan", "scan.obj"), ("regions", "regions"), ("plan", "plan.xml"), ("model", "model"),
                            ("dataset", "dataset"), ("environment", "light.exr"), ("report", "report")):
            setattr(self.settings, field, os.path.join(self.folder, name))
        self.before = state(self.scene)

    def write_program(self, fault="", sheet=b""):
        label_program.write_script(self.folder, PROGRAM, fault=fault, sheet=sheet)

    def expect_refusal(self, words, operator, **options):
        with self.assertRaisesRegex(RuntimeError, words):
            operator(**options)
        self.assertEqual(state(self.scene), self.before)
        self.assertEqual(jobs.running, [])

    def test_programs_that_fail_are_quoted(self):
        self.expect_refusal("is not there; set the folder", bpy.ops.hm.bake)
        for fault, words in (("refuse", "line 3: index out of range; export it again"),
                             ("full", "the disk is full; free some space"), ("crash", "openhumanbrdf was stopped by signal 6"),
                             ("silent", "ended with code 2 and said nothing")):
            self.write_program(fault)
            for operator in (bpy.ops.hm.bake, bpy.ops.hm.produce, bpy.ops.hm.forecast, bpy.ops.hm.validate):
                self.expect_refusal(words, operator)

    def test_programs_of_another_version(self):
        self.write_program()
        self.expect_refusal("is no report of validate; choose the program", bpy.ops.hm.validate)
        self.expect_refusal("contact_sheet.png: was not written", bpy.ops.hm.show_samples)

    def test_fields_that_are_empty_or_name_nothing(self):
        self.write_program()
        for field, operator, words in (
                ("scan", bpy.ops.hm.bake, "Scan: is empty"), ("regions", bpy.ops.hm.bake, "Regions: is empty"),
                ("plan", bpy.ops.hm.produce, "Plan: is empty"), ("dataset", bpy.ops.hm.produce, "Dataset: is empty"),
                ("plan", bpy.ops.hm.forecast, "Plan: is empty"), ("model", bpy.ops.hm.validate, "Model: is empty"),
                ("environment", bpy.ops.hm.validate, "Environment: is empty")):
            kept = getattr(self.settings, field)
            setattr(self.settings, field, "")
            self.expect_refusal(words, operator)
            setattr(self.settings, field, kept)
        self.settings.regions = os.path.join(self.folder, "none")
        self.expect_refusal("none: Regions: is not there", bpy.ops.hm.bake)
        self.settings.report = os.path.join(self.folder, "none", "report")
        self.expect_refusal("the folder around report: is not there", bpy.ops.hm.validate)

    def test_people_that_were_given_up_are_a_result(self):
        self.write_program("given up")
        bpy.ops.hm.produce()
        self.assertIn("2 sets of 1 people made", job_loop.last_words["produce"])

    def start(self, operator, fault):
        """As in a window, where nothing waits."""
        self.write_program(fault)
        with unittest.mock.patch.object(job_loop.bpy, "app", Windowed(bpy.app)):
            operator()
        return jobs.running[-1]

    def until(self, is_there, timeout_s=20):
        end = time.monotonic() + timeout_s
        while not is_there():
            self.assertLess(time.monotonic(), end)
            time.sleep(0.01)

    def test_progress_and_cancel(self):
        job = self.start(bpy.ops.hm.bake, "hang")
        self.until(lambda: job.share() == 0.3)
        self.assertEqual(job.words(), "Baking: 9 s left")
        with unittest.mock.patch.object(job_loop.bpy, "app", Windowed(bpy.app)):
            self.assertRaisesRegex(RuntimeError, "still running", bpy.ops.hm.bake)   # one at a time
        bpy.ops.hm.cancel_job(kind="bake")
        self.until(job.is_done)
        label_loop.step()
        self.assertEqual((jobs.running, job_loop.last_words["bake"]), ([], "Baking: cancelled"))
        self.assertEqual(state(self.scene), self.before)

    def test_a_program_that_talks_much_is_not_kept_waiting(self):
        job = self.start(bpy.ops.hm.bake, "chatter")
        self.until(job.is_done)
        label_loop.step()
        self.assertEqual(job_loop.last_words["bake"], "Baked model")

    def test_an_error_of_a_job_is_said(self):
        job = self.start(bpy.ops.hm.produce, "refuse")
        self.until(job.is_done)
        label_loop.step()
        self.assertIn("index out of range", job_loop.last_words["produce"])

    def test_samples_become_an_image(self):
        from support import image_files
        path = os.path.join(self.folder, "sheet.png")
        image_files.png(path, 4, 2, [9] * 24, 3, 8)
        with open(path, "rb") as file:
            self.write_program("page", file.read())
        bpy.ops.hm.show_samples()
        self.assertIn("4 x 2", job_loop.last_words["produce"])
        from human_material.ui import tool_operators
        self.assertEqual(tuple(tool_operators.sheet(self.settings).size), (4, 2))

    def test_models_that_are_none(self):
        self.expect_refusal("model.xml: is no model of", bpy.ops.hm.show_model)
        model = self.settings.model
        os.makedirs(os.path.join(model, "maps", "a"))
        xml = '<model><texture_set name="a" folder="a"><map name="albedo"/></texture_set></model>'
        with open(os.path.join(model, "model.xml"), "w", encoding="ascii") as file:
            file.write(xml)
        self.expect_refusal("albedo.exr: the map is not there; bake again", bpy.ops.hm.show_model)
        with open(os.path.join(model, "maps", "a", "albedo.exr"), "w", encoding="ascii") as file:
            file.write("a")
        for text in ("", "v 0 0\nf 1/1 2/1 3/1\n", "usemtl b\n", "v 0 0 0\nvt 0 0\nusemtl a\nf 1/1 1/1 9/1\n"):
            with open(os.path.join(model, "mesh.obj"), "w", encoding="ascii") as file:
                file.write(text)
            self.expect_refusal("mesh.obj: is no mesh of", bpy.ops.hm.show_model)
        self.assertRaises(InputError, baked.sets_of, self.folder)

    def test_nothing_to_open(self):
        self.expect_refusal("scene.blend: Cycles' scene: is not there", bpy.ops.hm.open_cycles_scene)
        self.expect_refusal("is not there; make it again", bpy.ops.hm.open_page, path="/none/index.html")
        self.assertRaises(InputError, tools.verdict_of, self.folder)


class Windowed:
    """bpy.app of a Blender with a window."""
    background = False

    def __init__(self, app):
        self._app = app

    def __getattr__(self, name):
        return getattr(self._app, name)
