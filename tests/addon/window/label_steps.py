"""In a window: a person is labelled by strokes from nothing to at least 99 %, undone, redone, saved; the command line
finds the same. Arguments: folder for pictures and results, scan, true classes."""
import os
import subprocess
import sys
import time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.dirname(HERE)]

import bpy  # noqa: E402
import driver  # noqa: E402
import support  # noqa: E402,F401
from bpy_extras import view3d_utils  # noqa: E402
from mathutils import Vector  # noqa: E402

import human_material  # noqa: E402
from human_material.services import jobs, label_session, programs, scan_object, strokes  # noqa: E402
from human_material.ui import label_loop, label_operators, label_paint  # noqa: E402

ENOUGH = 0.99
MOST_STROKES = 40


class Labeller:
    """Who knows the truth and paints what is most wrong."""

    def __init__(self, window, session, truth):
        self.window, self.session, self.truth = window, session, truth
        scan = session.scan
        self.normals = {}
        self.areas = [self.area_of(f) for f in range(len(scan.faces))]
        self.neighbours = self.find_neighbours()

    def area_of(self, face):
        scan = self.session.scan
        places = [Vector(scan.positions[3 * v:3 * v + 3])
                  for v in (scan.faces.vertices[c] for c in scan.faces.corners(face))]
        return sum((b - places[0]).cross(c - places[0]).length / 2 for b, c in zip(places[1:], places[2:]))

    def find_neighbours(self):
        faces_of = {}
        for f in self.session.scan.kept:
            for c in self.session.scan.faces.corners(f):
                faces_of.setdefault(self.session.scan.faces.vertices[c], []).append(f)
        self.faces_of = faces_of

    def share_right(self):
        classes = self.session.classes
        right = sum(a for a, t, c in zip(self.areas, self.truth, classes) if t == c)
        return right / sum(self.areas)

    def regions(self):
        """Connected wrong faces of one true class, the largest area first."""
        classes, faces = self.session.classes, self.session.scan.faces
        wrong = {f for f in self.session.scan.kept if classes[f] != self.truth[f]}
        found = []
        while wrong:
            front, region = [wrong.pop()], []
            while front:
                f = front.pop()
                region.append(f)
                for c in faces.corners(f):
                    for g in self.faces_of[faces.vertices[c]]:
                        if g in wrong and self.truth[g] == self.truth[f]:
                            wrong.discard(g)
                            front.append(g)
            found.append(region)
        return sorted(found, key=lambda r: -sum(self.areas[f] for f in r))

    def middle(self, region):
        """The face that is farthest from the region's border, by rings of faces."""
        faces, left = self.session.scan.faces, set(region)
        last = region
        while left:
            last = sorted(left)
            left = {f for f in left if all(g in left for c in faces.corners(f)
                                           for g in self.faces_of[faces.vertices[c]])}
            if len(left) == len(last):
                break
        return last[len(last) // 2]

    def at_screen(self, face):
        item = self.session.item
        world = item.matrix_world @ Vector(self.session.scan.centre(face))
        return view3d_utils.location_3d_to_region_2d(self.window.region(), self.window.view(), world)

    def look_at(self, face):
        item = self.session.item
        normal = item.matrix_world.to_3x3() @ label_operators.face_normal(self.session.scan, face)
        world = item.matrix_world @ Vector(self.session.scan.centre(face))
        view = self.window.view()
        label_operators.set_view(view, label_operators.view_of(view, world, normal, 0.5))
        self.window.area.tag_redraw()

    def is_seen(self, face):
        """Whether the pointer would meet it: nothing is before it."""
        x, y = self.at_screen(face)
        item = self.session.item
        with self.window.override():
            hit = self.session.nearest(*label_paint.ray(bpy.context, item, x, y))
        return hit is not None and hit[2] == face

    def find_place(self):
        """The view goes to what is most wrong and can be seen from where it faces; gives the face."""
        for region in self.regions()[:10]:
            middle = self.middle(region)
            for face in (middle, *region[::max(1, len(region) // 5)]):
                self.look_at(face)
                if self.is_seen(face):
                    return face
        raise AssertionError("nothing that is wrong can be seen")

    def paint(self):
        """One stroke on the middle of what is most wrong, as a drag of the pointer."""
        face = self.find_place()
        settings_now().class_name = strokes.CLASSES[self.truth[face]]
        yield
        x, y = self.at_screen(face)
        before = len(scan_object.strokes_of(self.session.item))
        yield from self.window.drag([(x, y), (x + 1, y)])
        yield from self.window.wait(lambda: len(scan_object.strokes_of(self.session.item)) > before, "the stroke", 60)
        yield from self.window.wait(self.session.is_settled, "the answer", 60)


def command_line(folder, scan, strokes_file):
    output = os.path.join(folder, "by_command_line")
    subprocess.run([programs.find("openhumanbrdf"), "label", scan, "--strokes", strokes_file, "-o", output],
                   check=True, capture_output=True)
    with open(os.path.join(output, "faces.txt"), encoding="ascii") as file:
        return [int(line) for line in file]


def open_scan(window, scan):
    yield
    for item in list(bpy.data.objects):
        bpy.data.objects.remove(item)
    window.area.spaces.active.show_region_ui = True
    with window.override():
        bpy.ops.hm.open_scan("EXEC_DEFAULT", filepath=scan)
    yield from window.wait(lambda: bpy.context.view_layer.objects.active is not None, "the scan")
    session = label_session.of(bpy.context.view_layer.objects.active)
    yield from window.wait(session.is_settled, "the first answer")
    return session


def beats(done):
    """How long the window stood still while strokes were answered: processor seconds of each step of the loop that changed something."""
    step = label_loop.step

    def timed():
        start = time.thread_time()   # other programs on the machine do not count
        changed = step()
        if changed:
            done.append(time.thread_time() - start)
        return changed
    label_loop.step = timed


def steps(window, folder, scan, truth):
    session = yield from open_scan(window, scan)
    held = []
    beats(held)
    with window.override():
        bpy.ops.hm.label_tool()
    settings_now().radius_cm = 1.0
    yield from window.click_window(1044, 272)   # the tab Human Material
    labeller = Labeller(window, session, truth)
    shares = [labeller.share_right()]
    yield from window.picture("1_opened")
    while shares[-1] < ENOUGH and len(shares) <= MOST_STROKES:
        start = time.perf_counter()
        yield from labeller.paint()
        shares.append(labeller.share_right())
        print("stroke %d: %.4f right, %.1f s" % (len(shares) - 1, shares[-1], time.perf_counter() - start), flush=True)
    assert shares[-1] >= ENOUGH, shares
    if len(shares) == 1:   # right from the start: a stroke to undo is needed all the same
        labeller.truth = [3] * len(truth)
        yield from labeller.paint()
        labeller.truth = truth
    yield from window.picture("2_painted")
    painted, count = bytes(session.classes), session.stroke_count
    window.key("Z", ctrl=True)
    yield from window.wait(lambda: session.is_settled() and session.stroke_count == count - 1, "undo")
    undone = bytes(session.classes)
    assert undone != painted
    window.key("Z", ctrl=True, shift=True)
    yield from window.wait(lambda: session.is_settled() and session.stroke_count == count, "redo")
    assert sum(a != b for a, b in zip(session.classes, painted)) <= 5
    yield from compare(window, folder, scan, session)
    print("answers held the window for at most %.3f s, %.3f s in the mean; %d strokes"
          % (max(held), sum(held) / len(held), count))
    yield from views(window, session, labeller)


def compare(window, folder, scan, session):
    """Saves by the panel; the command line's result of the same strokes is the same."""
    file = os.path.join(folder, "strokes.xml")
    with window.override():
        bpy.ops.hm.save_strokes("EXEC_DEFAULT", filepath=file)
        bpy.ops.hm.save_regions("EXEC_DEFAULT", directory=folder, folder_name="regions")
    shown = bytes(session.classes)
    yield from window.wait(lambda: not jobs.running, "REGIONS")
    yield
    expected = command_line(folder, scan, file)
    differing = sum(a != b for a, b in zip(shown, expected))
    print("%d of %d faces differ from the command line before saving" % (differing, len(expected)))
    assert differing <= len(expected) // 10000 + 5, differing
    yield from window.wait(session.is_settled, "what was saved")
    assert list(session.classes) == expected
    with open(os.path.join(folder, "regions", "faces.txt"), encoding="ascii") as saved:
        assert [int(line) for line in saved] == expected


def settings_now():
    """Undo makes the scene anew: a pointer from before it is stale."""
    return bpy.context.scene.hm.label


def views(window, session, labeller):
    """Pictures of the other overlays, of an eraser and of a lasso under way."""
    settings = settings_now()
    with window.override():
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.view3d.view_selected()
    settings.show = "CLASSES"
    yield from window.picture("3_front_classes")
    before = window.view().view_location.copy()
    if session.suggested:
        with window.override():
            bpy.ops.hm.label_look("INVOKE_DEFAULT")
        yield from window.wait(lambda: abs(window.view().view_distance - 0.35) < 1e-4, "the flight", 60)
        assert (window.view().view_location - before).length > 1e-3
        with window.override():
            bpy.ops.view3d.view_axis(type="FRONT")
            bpy.ops.view3d.view_selected()
    yield from window.click_window(974, 180)   # the buttons Hair and Doubt
    yield from window.wait(lambda: settings_now().class_name == "hair", "the button Hair", 30)
    yield from window.click_window(988, 378)
    yield from window.wait(lambda: settings_now().show == "DOUBT", "the button Doubt", 30)
    settings = settings_now()
    yield from window.picture("4_front_doubt")
    settings.show = "PICTURE"
    yield from window.picture("5_front_picture")
    settings.show, settings.mode, settings.class_name = "CLASSES", "LASSO", "leather"
    region, count = window.region(), len(scan_object.strokes_of(session.item))
    x, y = region.width / 2, region.height / 2
    ring = [(x - 40, y - 30), (x + 40, y - 30), (x + 40, y + 30), (x - 40, y + 30)]
    window.move(*ring[0])
    yield
    window.button("PRESS")
    for place in ring[1:]:
        yield
        window.move(*place)
    yield from window.picture("6_lasso")
    window.button("RELEASE")
    yield from window.wait(lambda: len(scan_object.strokes_of(session.item)) > count, "the lasso's strokes")
    yield from window.wait(session.is_settled, "the lasso's answer")
    yield from window.picture("7_lassoed")
    window.key("Z", ctrl=True)
    yield from window.wait(lambda: session.is_settled() and session.stroke_count == count, "undo of the lasso")
    settings = settings_now()
    settings.mode, settings.radius_cm = "ERASER", 5
    face = scan_object.strokes_of(session.item)[-1]["points"][0][0]
    labeller.look_at(face)
    yield
    x, y = labeller.at_screen(face)
    yield from window.drag([(x, y), (x + 2, y)])
    yield from window.wait(lambda: len(scan_object.strokes_of(session.item)) < count, "the eraser", 20)


def main():
    folder, scan, labels = driver.arguments()
    human_material.register()
    with open(labels, encoding="ascii") as file:
        truth = [int(line) for line in file]
    window = driver.Window(folder)
    driver.drive(steps(window, folder, scan, truth), window)


main()
