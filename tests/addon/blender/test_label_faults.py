"""What goes wrong beside the label panel ends in words and leaves the scene as it was."""
import os
import unittest.mock

import bpy
from support import label_program, scene as s

from human_material.services import label_session, scan_object
from human_material.ui import label_loop, label_paint

STROKE = {"class": "leather", "radius_cm": 1.0, "points": [[0, 5.0, 5.0, 0.0]]}


def state(scene):
    """What belongs to the user."""
    return {"objects": sorted((o.name, tuple(o.location), o.select_get(), o.hide_render) for o in scene.objects),
            "active": getattr(bpy.context.view_layer.objects.active, "name", None), "data": s.data_counts(),
            "engine": scene.render.engine, "size": (scene.render.resolution_x, scene.render.resolution_y),
            "output": scene.render.filepath, "world": getattr(scene.world, "name", None),
            "view": scene.view_settings.view_transform, "unit": scene.unit_settings.system, "mode": bpy.context.mode}


class LabelFaults(s.Registered):
    def setUp(self):
        super().setUp()
        for kind in ("cube_add", "uv_sphere_add", "monkey_add"):   # a scene full of other things
            getattr(bpy.ops.mesh, "primitive_" + kind)(location=(3, 1, 2))
        bpy.ops.object.light_add(type="SUN")
        bpy.data.objects["Suzanne"].select_set(True)
        self.scene.render.engine = "BLENDER_WORKBENCH"
        self.folder = s.folder()
        self.scan = os.path.join(self.folder, "scan.obj")
        self.write_scan("a1")
        patch = unittest.mock.patch.dict(os.environ, {"HM_TOOLS": self.folder})
        patch.start()
        self.addCleanup(patch.stop)
        self.addCleanup(label_session.close_all)
        self.before = state(self.scene)

    def write_scan(self, text):
        with open(self.scan, "w", encoding="ascii") as file:
            file.write(text)

    def expect_refusal(self, words, operator, **options):
        """The operator's own report, and a scene as it was."""
        with self.assertRaisesRegex(RuntimeError, words):
            operator(**options)
        self.assertEqual(state(self.scene), self.before)
        self.assertFalse(label_session.opening)

    def expect_open_fails(self, fault, words):
        label_program.write(self.folder, fault)
        self.expect_refusal(words, bpy.ops.hm.open_scan, filepath=self.scan)
        self.assertFalse(label_session.sessions)

    def open(self, fault=""):
        label_program.write(self.folder, fault)
        bpy.ops.hm.open_scan(filepath=self.scan)
        self.item = bpy.context.object
        self.before = state(self.scene)
        return label_session.of(self.item)

    def stroke_fails(self, fault, words, hang_s=60):
        """Paints; the session ends with these words; labels and strokes stay."""
        session = self.open(fault)
        label_paint.add_strokes(self.item, [STROKE])
        with unittest.mock.patch.object(label_session, "HANG_S", hang_s):
            label_loop.wait(lambda: session.phase == "ended", 20)
        self.assertRegex(session.status + self.scene.hm.label.message, words)
        self.assertEqual(state(self.scene), self.before)
        self.assertEqual(scan_object.strokes_of(self.item), [STROKE])
        label_program.write(self.folder)   # mended
        bpy.ops.hm.label_start()
        session = label_session.of(self.item)
        label_loop.wait(session.is_settled, 20)
        self.assertEqual(list(session.classes), [3, 2])

    def test_programs_that_are_not_there_or_do_not_start(self):
        self.expect_refusal("is not there; set the folder", bpy.ops.hm.open_scan, filepath=self.scan)
        path = label_program.write(self.folder)
        os.chmod(path, 0o644)
        self.expect_refusal("make it executable", bpy.ops.hm.open_scan, filepath=self.scan)
        with open(path, "wb") as file:
            file.write(b"\x7fELF of another machine")
        os.chmod(path, 0o755)
        self.expect_refusal("cannot be started", bpy.ops.hm.open_scan, filepath=self.scan)
        del os.environ["HM_TOOLS"]
        with unittest.mock.patch.dict(os.environ, {"PATH": self.folder + "/none"}):
            self.expect_refusal("was not found; set the folder", bpy.ops.hm.open_scan, filepath=self.scan)

    def test_programs_of_another_version(self):
        self.expect_open_fails("words", "answers what is no answer.*of the add-on's version")
        self.expect_open_fails("other", "is of another version")
        self.expect_open_fails("old", '"mesh" is not known')
        self.expect_open_fails("short", "shorter than the program said")

    def test_a_program_that_refuses_the_scan_is_quoted(self):
        self.expect_open_fails("start", "line 3: index out of range; export it again")

    def test_a_program_that_hangs_is_given_up(self):
        with unittest.mock.patch.object(label_session, "HANG_S", 0.5):
            self.expect_open_fails("hang", "has not answered for")

    def test_a_crash_while_painting_keeps_labels_and_strokes(self):
        self.stroke_fails("crash", "has ended")

    def test_a_hang_while_painting_keeps_labels_and_strokes(self):
        self.stroke_fails("hang later", "has not answered for", hang_s=1.0)

    def test_garbage_while_painting_keeps_labels_and_strokes(self):
        self.stroke_fails("garbage", "answers what is no answer")

    def test_half_an_answer_while_painting_keeps_labels_and_strokes(self):
        self.stroke_fails("half", "does not understand")

    def test_a_refused_stroke_is_taken_back(self):
        session = self.open("refuse")
        label_paint.add_strokes(self.item, [STROKE])
        label_loop.wait(session.is_settled, 20)
        self.assertIn("9.0 cm away", self.scene.hm.label.message)
        self.assertEqual(scan_object.strokes_of(self.item), [])
        self.assertEqual((session.phase, list(session.classes)), ("ready", [2, 2]))

    def test_a_mesh_that_was_changed_takes_no_strokes(self):
        self.open()
        self.item.data.vertices[2].co.x += 1
        for operator, options in ((bpy.ops.hm.save_strokes, {"filepath": self.folder + "/s.xml"}),
                                  (bpy.ops.hm.save_regions, {"directory": self.folder}),
                                  (bpy.ops.hm.label_look, {})):
            self.expect_refusal("mesh was changed", operator, **options)
        label_session.close_all()
        self.expect_refusal("mesh was changed", bpy.ops.hm.label_start)
        self.assertEqual(sorted(os.listdir(self.folder)), ["openhumanbrdf", "scan.obj"])

    def test_a_scan_file_that_is_another_now(self):
        self.open()
        label_session.close_all()
        self.write_scan("b2")
        self.expect_refusal("is not the file that was labelled", bpy.ops.hm.label_start)
        os.remove(self.scan)
        self.expect_refusal("no longer there", bpy.ops.hm.label_start)
        self.expect_refusal("no such file", bpy.ops.hm.open_scan, filepath=self.scan)

    def test_one_scan_is_opened_once(self):
        self.open()
        self.expect_refusal("is in the scene already, as scan", bpy.ops.hm.open_scan, filepath=self.scan)

    def test_places_that_cannot_be_written(self):
        self.open()
        for path in ("/proc/none/s.xml", self.scan + "/s.xml"):
            self.expect_refusal("cannot be written", bpy.ops.hm.save_strokes, filepath=path)
        label_program.write(self.folder, "save")
        self.expect_refusal("choose another folder", bpy.ops.hm.save_regions, directory="/proc/none")

    def test_strokes_of_another_scan_are_not_replaced(self):
        self.open()
        path = os.path.join(self.folder, "s.xml")
        for text, words in (('<strokes schema="1.0" scan_sha256="ff"/>', "of another scan"), ("<str", "well-formed"),
                            ("<html/>", "holds no strokes")):
            with open(path, "w", encoding="ascii") as file:
                file.write(text)
            self.expect_refusal(words, bpy.ops.hm.save_strokes, filepath=path)
            with open(path, encoding="ascii") as file:
                self.assertEqual(file.read(), text)

    def test_two_windows_on_one_scan_do_not_overwrite_each_other(self):
        self.open()
        path = os.path.join(self.folder, "s.xml")
        bpy.ops.hm.save_strokes(filepath=path)
        bpy.ops.hm.save_strokes(filepath=path)   # its own
        with open(path, encoding="ascii") as file:
            text = file.read()
        with open(path, "w", encoding="ascii") as file:   # the other window
            file.write(text.replace("</strokes>", '<stroke class="hair" radius_cm="1"><point face="1" at="0,9,0"/>'
                                    '</stroke></strokes>'))
        self.before = state(self.scene)
        self.expect_refusal("were not saved from here; choose another name, or Overwrite", bpy.ops.hm.save_strokes,
                            filepath=path)
        bpy.ops.hm.save_strokes(filepath=path, overwrite=True)
        with open(path, encoding="ascii") as file:
            self.assertEqual(file.read(), text)

    def test_a_project_that_was_moved_finds_its_scan(self):
        self.open()
        label_session.close_all()
        moved = os.path.join(self.folder, "moved")
        os.mkdir(moved)
        os.rename(self.scan, os.path.join(moved, "scan.obj"))
        bpy.ops.wm.save_as_mainfile(filepath=os.path.join(moved, "a.blend"))
        bpy.ops.hm.label_start()
        self.assertEqual(label_session.of(bpy.context.object).phase, "ready")

    def test_strokes_that_cannot_be_gone_on_with(self):
        label_program.write(self.folder)
        path = os.path.join(self.folder, "s.xml")
        with open(path, "w", encoding="ascii") as file:
            file.write('<strokes schema="1.0"><stroke class="silk" radius_cm="1"/></strokes>')
        self.expect_refusal("stroke 1: is no stroke", bpy.ops.hm.open_scan, filepath=self.scan, strokes=path)

    def test_the_scan_is_removed_while_it_is_labelled(self):
        session = self.open()
        bpy.data.objects.remove(self.item)
        label_loop.step()
        self.assertEqual((session.phase, label_session.sessions), ("ended", {}))
        self.assertIn("removed from the scene", self.scene.hm.label.message)

    def test_a_renamed_scan_is_still_the_same(self):
        session = self.open()
        self.item.name = "Anna"
        label_paint.add_strokes(self.item, [STROKE])
        label_loop.wait(session.is_settled, 20)
        self.assertIs(label_session.of(self.item), session)
        self.assertEqual(self.item.data.attributes[scan_object.CLASS].data[0].value, 3)
