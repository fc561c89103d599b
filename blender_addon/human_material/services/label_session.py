# SPDX-License-Identifier: GPL-3.0-or-later
"""A scan in the scene and the program that labels it. The strokes are kept on the object, where Blender's undo reaches
them; the program is told whatever differs from what it has, one request at a time, and is never waited for."""
import json
import os
import shutil
import tempfile
import time

import bpy
from mathutils.bvhtree import BVHTree

from . import overlay, scan_object
from .errors import InputError
from .labelling import Ended, Labelling
from .scan_mesh import ScanMesh

HANG_S = 120   # no answer to a stroke for so long: the program hangs (it takes 0.1 s)
READING = 5    # times that to read a scan: 100 000 faces and a picture of 8192 px are 12 s of an idle processor

sessions = {}   # name of the object -> Session
opening = []    # sessions whose object is not there yet


class Session:
    """`phase`: "reading", "meshing", "ready" or "ended"."""

    def __init__(self, program, path, unit="", up="", item=None, strokes=()):
        self.path, self.options = path, {"unit": unit, "up": up}
        self.name = item.name if item else ""
        self.first_strokes = list(strokes)
        self._talk = Labelling(program, path, unit or None, up or None)
        self._folder = tempfile.mkdtemp(prefix="hm_label")
        self.phase, self.status = "reading", "Reading the scan"
        self._asked_at, self._is_waiting = time.monotonic(), True
        self._have, self._asked, self._seen_text = [], [], None
        self.scan = self._overlay = self._tree = None
        self.unit_cm, self.shown, self.answers = 1.0, "CLASSES", 0
        self._dirty = True

    # What the panel reads.
    suggested = property(lambda self: self._talk.suggested)
    questions = property(lambda self: self._talk.questions)
    warnings = property(lambda self: self._talk.warnings)
    classes = property(lambda self: self._talk.classes)
    confidence = property(lambda self: self._talk.confidence)
    stroke_count = property(lambda self: len(self._have))

    @property
    def item(self):
        """The object, also under another name; None if it is gone."""
        found = bpy.data.objects.get(self.name)
        if not scan_object.is_scan(found) and self.name:
            found = next((other for other in bpy.data.objects if scan_object.is_scan(other)
                          and other[scan_object.SCAN] == self.path and other.name not in sessions), None)
            if found is not None:
                sessions.pop(self.name, None)
                self.name = found.name
                sessions[self.name] = self
        return found

    def is_settled(self):
        """Whether every stroke of the object has been answered."""
        return (self.phase == "ready" and not self._is_waiting and self.item is not None
                and self.item[scan_object.STROKES] == self._seen_text)

    def poll(self, scene):
        """Takes over what has been answered and asks what is to be asked. Gives whether something changed.

        Raises InputError for what the user should read; after Ended the session is over.
        """
        changed = False
        try:
            while self._take_next(scene):
                changed = True
            patience_s = HANG_S * (1 if self.phase == "ready" else READING)
            if self._is_waiting and time.monotonic() - self._asked_at > patience_s:
                raise Ended("", "openhumanbrdf label", "has not answered for %g s" % patience_s, "start it again")
            if self.phase == "ready" and self.item is None:
                raise Ended(self.name, "", "the scan was removed from the scene")
            if self.phase == "ready" and not self._is_waiting:
                self._tell_difference()
        except Ended:
            self.close()
            raise
        except InputError:
            self._is_waiting = False
            if self.phase != "ready":   # it cannot hand over its mesh
                self.close()
                raise
            scan_object.set_strokes(self.item, self._have)   # the refused stroke
            raise
        if self._dirty and self.phase == "ready" and self.item is not None:
            self._repaint()
            changed = True
        return changed

    def _ask(self, number, *_):
        self._asked_at, self._is_waiting = time.monotonic(), True

    def _take_next(self, scene):
        try:
            answer = self._talk.answer(0)
            if answer is None:
                return False
            self._is_waiting = False
            self._take(scene, answer)
            return True
        except (KeyError, TypeError, ValueError, IndexError) as error:
            raise Ended("", "openhumanbrdf label", "answers what the add-on does not understand (%r)" % error,
                        "choose the program of the add-on's version") from None

    def _take(self, scene, answer):
        if self.phase == "reading":
            if not answer.get("ready"):
                raise Ended("", "openhumanbrdf label", "is of another version",
                            "choose the program of the add-on's version")
            self.unit_cm = answer["unit_cm"]
            self.phase, self.status = "meshing", "Taking over the scan"
            self._ask(self._talk.mesh(self._folder))
        elif self.phase == "meshing":
            self._take_mesh(scene, answer)
        elif "changed" in answer:
            self._have = self._asked
            self.answers += 1
            self.status = "%d stroke%s, %.2f s" % (len(self._have), "" if len(self._have) == 1 else "s",
                                                   answer.get("seconds", 0))
            self._paint(answer)

    def _take_mesh(self, scene, answer):
        self.scan = ScanMesh(answer)
        if not self.name:
            name = os.path.splitext(os.path.basename(self.path))[0]
            item = scan_object.build(scene, self.scan, name, self.path, self.unit_cm, self.options)
            scan_object.set_strokes(item, self.first_strokes)
            self.name = item.name
        elif self.item is None:
            raise Ended(self.name, "", "the scan was removed from the scene")
        elif self.item[scan_object.SHA256] != self.scan.sha256:
            raise Ended(self.path, "", "is not the file that was labelled", "open it again as another scan")
        else:
            scan_object.expect_unchanged(self.item)
        self._overlay = overlay.Overlay(self.scan, scan_object.corner_brightness(self.item, self.scan))
        self._tree = _tree_of(self.scan)
        self.phase, self.status = "ready", "Ready"

    def _tell_difference(self):
        """Sends one request that brings the program nearer to the strokes of the object."""
        text = self.item[scan_object.STROKES]
        if text == self._seen_text:
            return
        want = json.loads(text)
        if want == self._have:
            self._seen_text = text
            return
        self._asked = want
        plain = [{k: v for k, v in stroke.items() if k != "group"} for stroke in want]
        if want[:-1] == self._have:
            self._ask(self._talk.stroke(want[-1]["class"], want[-1]["radius_cm"], want[-1]["points"]))
        else:
            self._ask(self._talk.strokes(plain))

    def _paint(self, answer):
        item = self.item
        if item is None:
            return
        scan_object.store(item, self.scan, self.classes, self.confidence)
        if not self._dirty and self.shown != "PICTURE":
            self._overlay.paint(answer["changed" if self.shown == "CLASSES" else "confidence"], self.shown)
            self._overlay.write(item.data)

    def _repaint(self):
        self._dirty = False
        scan_object.store(self.item, self.scan, self.classes, self.confidence)
        if self.shown != "PICTURE":
            values = self.classes if self.shown == "CLASSES" else self.confidence
            self._overlay.paint(overlay.runs_of(values), self.shown)
            self._overlay.write(self.item.data)

    def set_dirty(self):
        """After undo, redo, or another overlay: what is shown is not what is known."""
        self._dirty, self._seen_text = True, None

    def take_classes(self, values):
        """The classes that the command line found for these strokes: what is saved is what is shown."""
        self._talk.classes[:] = bytes(values)
        self._dirty = True

    def nearest(self, origin, direction):
        """(place, normal, face of the scan) of a ray in the scan's axes, or None."""
        place, normal, index, _ = self._tree.ray_cast(origin, direction)
        return None if place is None else (place, normal, self.scan.kept[index])

    def share_in_doubt(self):
        """Of the faces: less sure than 0.8, as the program's report has it."""
        values = self.confidence
        return sum(value < 12 for value in values) / max(len(values), 1)

    def close(self):
        """Ends the program; the object and its labels stay."""
        self.phase, self.status = "ended", "The program has ended"
        self._talk.close(0.2)
        shutil.rmtree(self._folder, ignore_errors=True)
        sessions.pop(self.name, None)
        if self in opening:
            opening.remove(self)


def _tree_of(scan):
    """For rays: built once, as colours of the mesh change after every stroke."""
    positions, faces = scan.positions, scan.faces
    places = [positions[k:k + 3] for k in range(0, len(positions), 3)]
    polygons = [faces.vertices[faces.first_corner[f]:faces.first_corner[f + 1]] for f in scan.kept]
    return BVHTree.FromPolygons(places, polygons)


def open_scan(program, path, unit="", up="", strokes=()):
    """Starts to read a scan; its object comes with a later poll."""
    if not os.path.isfile(path):
        raise InputError(path, "", "there is no such file", "choose an OBJ, GLB or FBX")
    for item in bpy.data.objects:
        if scan_object.is_scan(item) and os.path.realpath(item[scan_object.SCAN]) == os.path.realpath(path):
            raise InputError(path, "", "is in the scene already, as %s" % item.name, "go on with that one")
    session = Session(program, path, unit, up, strokes=strokes)
    opening.append(session)
    return session


def resume(program, item):
    """Starts the program for a scan that is in the scene (a .blend that was opened again)."""
    if item.name in sessions:
        return sessions[item.name]
    beside = os.path.join(os.path.dirname(bpy.data.filepath), os.path.basename(item[scan_object.SCAN]))
    if not os.path.isfile(item[scan_object.SCAN]) and os.path.isfile(beside):   # the project was moved
        item[scan_object.SCAN] = beside
    if not os.path.isfile(item[scan_object.SCAN]):
        raise InputError(item[scan_object.SCAN], "", "the scan is no longer there", "put it back, or beside the .blend")
    scan_object.expect_unchanged(item)
    options = json.loads(item[scan_object.OPTIONS])
    sessions[item.name] = Session(program, item[scan_object.SCAN], options["unit"], options["up"], item=item)
    return sessions[item.name]


def of(item):
    """The session of an object, or None."""
    return sessions.get(item.name) if scan_object.is_scan(item) else None


def poll_all(scene):
    """Polls every session. Gives (whether something changed, new objects, [what the user should read])."""
    changed, new, errors = False, [], []
    for session in [*opening, *sessions.values()]:
        was_named = bool(session.name)
        try:
            changed |= session.poll(scene)
        except InputError as error:
            session.status = str(error)
            errors.append(str(error))
            changed = True
        if session in opening and session.name:
            opening.remove(session)
            sessions[session.name] = session
        if not was_named and session.name and session.phase == "ready":
            new.append(session.item)
    return changed, new, errors


def close_all():
    for session in [*opening, *sessions.values()]:
        session.close()
    opening.clear()
    sessions.clear()
