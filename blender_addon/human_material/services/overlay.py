# SPDX-License-Identifier: GPL-3.0-or-later
"""Classes and doubt as colours of the mesh's corners, changed only where an answer changed something."""
from array import array

from . import classes

COLORS = tuple(tuple(entry["color"]) for entry in classes.TABLE)   # linear, as `label` has them
UNKNOWN = (0.5, 0.5, 0.5)
SURE, DOUBT = (0.10, 0.13, 0.17), (1.0, 0.62, 0.02)
ATTRIBUTE = "hm_overlay"


def class_color(value):
    return COLORS[value] if value < len(COLORS) else UNKNOWN


def doubt_color(confidence):
    """confidence from 0 to 15: from 13 on sure; below 12 (0.8) `label` calls it in doubt; orange from 9 down."""
    share = min(max((13 - confidence) / 4, 0.0), 1.0)
    return tuple(a + share * (b - a) for a, b in zip(SURE, DOUBT))


class Overlay:
    """Colours (RGBA, linear) of the kept faces' corners. `show`: "CLASSES" or "DOUBT"."""

    def __init__(self, scan, brightness):
        self._first = array("i", [0])   # of each face of the scan; faces that are not kept have no corners
        kept = set(scan.kept) if len(scan.kept) < len(scan.faces) else None
        for f in range(len(scan.faces)):
            is_kept = kept is None or f in kept
            self._first.append(self._first[-1] + (len(scan.faces.corners(f)) if is_kept else 0))
        self._brightness = brightness
        self._whole = {}   # colour -> that colour at every corner, shaded
        self.colors = array("f", bytes(16 * self._first[-1]))

    def _shaded(self, color):
        if color not in self._whole:
            shades = [0.35 + 0.9 * value for value in self._brightness]
            whole = array("f", [1.0]) * (4 * len(shades))
            for c, value in enumerate(color):
                whole[c::4] = array("f", [value * shade for shade in shades])
            self._whole[color] = whole
        return self._whole[color]

    def paint(self, runs, show):
        """runs: (first face, count, value) of classes or of confidence."""
        for first, count, value in runs:
            begin, end = 4 * self._first[first], 4 * self._first[first + count]
            if show == "CLASSES":
                self.colors[begin:end] = self._shaded(class_color(value))[begin:end]
            else:
                self.colors[begin:end] = array("f", (*doubt_color(value), 1.0)) * ((end - begin) // 4)

    def write(self, mesh):
        layer = mesh.color_attributes.get(ATTRIBUTE)
        if layer is None or len(layer.data) * 4 != len(self.colors):
            if layer is not None:
                mesh.color_attributes.remove(layer)
            layer = mesh.color_attributes.new(ATTRIBUTE, "FLOAT_COLOR", "CORNER")
        mesh.color_attributes.active_color = layer
        layer.data.foreach_set("color", self.colors)
        mesh.update_tag()


def runs_of(values):
    """[first, count, value] of all values."""
    runs, begin = [], 0
    for k in range(1, len(values) + 1):
        if k == len(values) or values[k] != values[begin]:
            runs.append((begin, k - begin, values[begin]))
            begin = k
    return runs
