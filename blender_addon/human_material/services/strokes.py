# SPDX-License-Identifier: GPL-3.0-or-later
"""Strokes of a scan as plain data, and strokes.xml. No bpy.

A stroke is {"class", "radius_cm", "points": [[face, x, y, z], ...]}, and "group" where several are one deed of the
user. Positions are in the scan's unit and axes.
"""
import math
import xml.etree.ElementTree as xml

from . import classes
from .errors import InputError

CLASSES = classes.NAMES
DOTS_OF_STROKE = 250     # of a fill: a stroke's cost grows with their square
MOST_DOTS = 4000         # of one fill
DOT_RADIUS_CM = 0.01     # a dot covers its own face alone


def _read_stroke(node, file, place):
    try:
        points = [[int(p.get("face")), *(float(c) for c in p.get("at").split(","))] for p in node.findall("point")]
        stroke = {"class": node.get("class"), "radius_cm": float(node.get("radius_cm")), "points": points}
        time_s = float(node.get("time_s", 0))
    except (TypeError, ValueError, AttributeError):
        raise InputError(file, place, "is no stroke", "see docs/label_files.md") from None
    if stroke["class"] not in CLASSES or not points or any(len(p) != 4 for p in points) \
            or not all(math.isfinite(c) for p in points for c in p):
        raise InputError(file, place, "is no stroke", "see docs/label_files.md")
    return time_s, stroke


def read(file):
    """(the strokes in the order of their times, the SHA-256 of their scan or ""). Raises InputError."""
    try:
        root = xml.parse(file).getroot()
    except OSError as error:
        raise InputError(file, "", "cannot be read (%s)" % error.strerror) from None
    except xml.ParseError as error:
        raise InputError(file, "", "is no well-formed XML (%s)" % error) from None
    if root.tag != "strokes" or not root.get("schema", "").startswith("1."):
        raise InputError(file, "", "holds no strokes of schema 1", "choose a strokes.xml")
    timed = [_read_stroke(node, file, "stroke %d" % (k + 1)) for k, node in enumerate(root.findall("stroke"))]
    timed.sort(key=lambda pair: pair[0])
    return [stroke for _, stroke in timed], root.get("scan_sha256", "")


def of_faces(class_name, faces, centre_of, group):
    """Strokes that dot these faces, at most MOST_DOTS of them, evenly."""
    step = max(1, -(-len(faces) // MOST_DOTS))
    dots = [[face, *centre_of(face)] for face in faces[::step]]
    return [{"class": class_name, "radius_cm": DOT_RADIUS_CM, "points": dots[k:k + DOTS_OF_STROKE], "group": group}
            for k in range(0, len(dots), DOTS_OF_STROKE)]


def erased(strokes, path, radius_cm, unit_cm):
    """The strokes that an eraser's path does not touch. Strokes of one group go together."""
    def touches(stroke):
        reach = (radius_cm + stroke["radius_cm"]) / unit_cm
        points = [p[1:] for p in stroke["points"]]
        return any(_distance(place, points[max(k - 1, 0)], points[k]) <= reach
                   for place in path for k in range(len(points)))
    gone = [touches(stroke) for stroke in strokes]
    groups = {stroke["group"] for stroke, is_gone in zip(strokes, gone) if is_gone and "group" in stroke}
    return [stroke for stroke, is_gone in zip(strokes, gone) if not is_gone and stroke.get("group") not in groups]


def _distance(p, a, b):
    """From p to the line from a to b."""
    along = [q - r for q, r in zip(b, a)]
    squared = sum(c * c for c in along)
    t = sum((q - r) * c for q, r, c in zip(p, a, along)) / squared if squared > 0 else 0.0
    t = min(max(t, 0.0), 1.0)
    return math.dist(p, [r + t * c for r, c in zip(a, along)])


class Painter:
    """The line of a brush while the button is down: a new stroke wherever the line leaves the surface."""

    def __init__(self, class_name, radius_cm, unit_cm):
        self.class_name, self.radius_cm, self.unit_cm = class_name, radius_cm, unit_cm
        self.lines, self._is_off = [], True

    def add(self, face, place):
        """A point on the surface; points nearer than a quarter of the radius are left out."""
        point = [face, *place]
        if not self._is_off and self.lines:
            way_cm = math.dist(self.lines[-1][-1][1:], place) * self.unit_cm
            if way_cm < self.radius_cm / 4:
                return
            self._is_off = way_cm > max(4 * self.radius_cm, 5.0)   # from one sleeve to the other
        if self._is_off:
            self.lines.append([])
        self.lines[-1].append(point)
        self._is_off = False

    def leave(self):
        self._is_off = True

    def strokes(self, group):
        result = [{"class": self.class_name, "radius_cm": round(self.radius_cm, 4), "points": line}
                  for line in self.lines]
        return [dict(stroke, group=group) for stroke in result] if len(result) > 1 else result
