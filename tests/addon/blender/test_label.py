"""The label panel without a window: a scan is opened, stroked, undone, saved; the same as the command line."""
import json
import os
import subprocess
import unittest

import bpy
from support import ROOT, scene as s

from human_material.services import label_session, programs, scan_object, strokes
from human_material.services.errors import InputError
from human_material.ui import label_loop, label_paint

EXAMPLE = os.path.join(ROOT, "assets", "example_human")
SCAN = os.path.join(EXAMPLE, "example_human.glb")


def program():
    try:
        return programs.find("openhumanbrdf")
    except InputError as error:
        raise unittest.SkipTest("%s (HM_TOOLS)" % error)


def truth():
    with open(os.path.join(EXAMPLE, "example_human.labels.txt"), encoding="ascii") as file:
        return [int(line) for line in file]


def stroke_at(session, face, class_name, radius_cm=1.5):
    return {"class": class_name, "radius_cm": radius_cm, "points": [[face, *session.scan.centre(face)]]}


def command_line_classes(folder, strokes_file):
    output = os.path.join(folder, "by_command_line")
    subprocess.run([program(), "label", SCAN, "--strokes", strokes_file, "-o", output], check=True,
                   capture_output=True)
    with open(os.path.join(output, "faces.txt"), encoding="ascii") as file:
        return [int(line) for line in file]


class Label(s.Registered):
    def setUp(self):
        super().setUp()
        program()
        self.addCleanup(label_session.close_all)

    def open(self, **options):
        bpy.ops.hm.open_scan(filepath=SCAN, **options)
        self.item = bpy.context.object
        return label_session.of(self.item)

    def settle(self, session):
        label_loop.wait(session.is_settled, 60)

    def test_the_scan_is_as_the_program_reads_it(self):
        session = self.open()
        self.assertEqual(len(session.classes), len(truth()))
        mesh = self.item.data
        self.assertEqual(len(mesh.polygons), len(session.scan.kept))
        self.assertEqual(list(scan_object.face_numbers(mesh)), session.scan.kept)
        self.assertTrue(1.4 < self.item.dimensions.y < 2.1)   # metres; before the turn Y is up
        self.assertAlmostEqual(self.item.rotation_euler.x, 1.5707963, 5)
        image = next(n.image for n in mesh.materials[0].node_tree.nodes if n.type == "TEX_IMAGE")
        self.assertEqual(tuple(image.size), (2048, 2048))
        for name in (scan_object.CLASS, scan_object.CONFIDENCE):
            self.assertEqual(mesh.attributes[name].domain, "FACE")

    def test_strokes_change_attributes_and_overlay_and_are_undone(self):
        session = self.open()
        start = bytes(session.classes)
        trousers = next(f for f, c in enumerate(truth()) if c == 2 and session.scan.centre(f)[1] < 0.6)
        bpy.ops.ed.undo_push(message="before")
        label_paint.add_strokes(self.item, [stroke_at(session, trousers, "leather")])
        bpy.ops.ed.undo_push(message="stroke")
        self.settle(session)
        self.assertEqual(session.classes[trousers], 3)
        values = [0] * len(self.item.data.polygons)
        self.item.data.attributes[scan_object.CLASS].data.foreach_get("value", values)
        self.assertEqual(values, [session.classes[f] for f in session.scan.kept])
        overlay = self.item.data.color_attributes["hm_overlay"]
        corner = self.item.data.polygons[session.scan.kept.index(trousers)].loop_start
        red, green, blue, _ = overlay.data[corner].color
        self.assertGreater(red, 2 * max(green, blue))   # leather's colour, whatever the shade
        painted = bytes(session.classes)
        bpy.ops.ed.undo()
        self.settle(session)
        self.assertEqual(session.stroke_count, 0)
        self.assertEqual(bytes(session.classes), start)
        bpy.ops.ed.redo()
        self.settle(session)
        self.assertEqual(bytes(session.classes), painted)

    def test_what_is_saved_is_what_the_command_line_finds(self):
        folder = s.folder()
        session = self.open()
        known = truth()
        for _ in range(6):
            wrong = [f for f in session.scan.kept if session.classes[f] != known[f]]
            if not wrong:
                break
            face = wrong[len(wrong) // 2]
            label_paint.add_strokes(self.item, [stroke_at(session, face, strokes.CLASSES[known[face]])])
            self.settle(session)
        shown = bytes(session.classes)
        file = os.path.join(folder, "strokes.xml")
        bpy.ops.hm.save_strokes(filepath=file)
        expected = command_line_classes(folder, file)
        differing = sum(a != b for a, b in zip(shown, expected))
        print("%d strokes; %d of %d faces differ from the command line while painting"
              % (session.stroke_count, differing, len(expected)))
        self.assertLessEqual(differing, 5)   # each answer starts from the one before
        bpy.ops.hm.save_regions(directory=folder, folder_name="regions")
        self.settle(session)
        self.assertEqual(list(session.classes), expected)
        with open(os.path.join(folder, "regions", "faces.txt"), encoding="ascii") as saved:
            self.assertEqual([int(line) for line in saved], expected)
        self.assertTrue(os.path.exists(os.path.join(folder, "regions", "strokes.xml")))

    def test_saved_strokes_and_files_are_gone_on_with(self):
        folder = s.folder()
        session = self.open()
        label_paint.add_strokes(self.item, [stroke_at(session, 5000, "leather"), stroke_at(session, 9000, "hair")])
        self.settle(session)
        painted = bytes(session.classes)
        file, blend = os.path.join(folder, "strokes.xml"), os.path.join(folder, "a.blend")
        bpy.ops.hm.save_strokes(filepath=file)
        bpy.ops.wm.save_as_mainfile(filepath=blend)
        bpy.ops.wm.open_mainfile(filepath=blend)
        self.assertFalse(label_session.sessions)
        bpy.ops.hm.label_start()
        session = label_session.of(bpy.context.object)
        self.settle(session)
        self.assertEqual(session.stroke_count, 2)
        self.assertLessEqual(sum(a != b for a, b in zip(session.classes, painted)), 5)
        s.empty_scene()
        session = self.open(strokes=file)
        self.assertEqual(session.stroke_count, 2)

    def test_fills_take_what_they_say(self):
        session = self.open()
        piece = session.scan.faces.of_piece(100)
        island = session.scan.faces.of_island(100)
        self.assertTrue(set(island) <= set(piece))
        self.assertEqual(len(session.scan.faces.of_material(100)), len(truth()))   # one atlas
        few = island[:300]
        label_paint.fill(session, "leather", few)
        self.settle(session)
        self.assertEqual({session.classes[f] for f in few}, {3})
        self.assertEqual(len(scan_object.strokes_of(self.item)), 2)   # of 250 dots each
        middle = session.scan.centre(few[0])
        left = strokes.erased(scan_object.strokes_of(self.item), [middle], 0.5, session.unit_cm)
        self.assertEqual(left, [])   # one fill is one deed

    def test_a_garment_that_is_asked_about_is_answered(self):
        session = self.open()
        if not session.questions:
            self.skipTest("nothing is asked about this person")
        question = session.questions[0]
        bpy.ops.hm.label_answer(garment=question["id"], class_name=question["rival"])
        self.settle(session)
        self.assertEqual(strokes.CLASSES[session.classes[question["face"]]], question["rival"])
        self.assertNotIn(question["id"], [q["id"] for q in session.questions])
        self.assertEqual(json.loads(self.item[scan_object.STROKES])[0]["radius_cm"], 1.0)


