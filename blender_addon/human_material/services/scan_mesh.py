# SPDX-License-Identifier: GPL-3.0-or-later
"""The scan as `openhumanbrdf label --serve` hands it over: the same faces in the same order, whatever the format was.
Blender's own importers drop and reorder faces. No bpy."""
import os
from array import array

from .errors import InputError
from .fills import Faces


def _take(file, kind, count, path):
    values = array(kind)
    try:
        values.fromfile(file, count)
    except (EOFError, ValueError):
        raise InputError(path, "", "is shorter than the program said", "start it again") from None
    return values


class ScanMesh:
    """positions (3 a vertex), faces (fills.Faces), materials [(name, picture or "", color)], and which faces Blender
    can hold: one that has a corner twice is kept out of the mesh, and keeps its number."""

    def __init__(self, answer):
        try:
            path, positions, faces, corners = (answer[k] for k in ("file", "positions", "faces", "corners"))
            self.sha256 = answer["scan_sha256"]
            self.materials = [(m["name"], m["picture"], m["color"]) for m in answer["materials"]]
        except (KeyError, TypeError):
            raise InputError("", "openhumanbrdf label", "is of another version",
                             "choose the program of the add-on's version") from None
        with open(path, "rb") as file:
            self.positions = _take(file, "f", 3 * positions, path)
            first = _take(file, "I", faces + 1, path)
            vertices = _take(file, "I", corners, path)
            uvs = _take(file, "f", 2 * corners, path)
            materials = _take(file, "H", faces, path)
        os.remove(path)
        self.faces = Faces(array("i", first), array("i", vertices), uvs, materials)
        self.kept = self._faces_to_keep()

    def _faces_to_keep(self):
        first, vertices = self.faces.first_corner, self.faces.vertices
        return [f for f in range(len(self.faces))
                if first[f + 1] - first[f] == len(set(vertices[first[f]:first[f + 1]])) > 2]

    def centre(self, face):
        corners = [self.positions[3 * v:3 * v + 3] for v in (self.faces.vertices[c] for c in self.faces.corners(face))]
        return [sum(values) / len(corners) for values in zip(*corners)]
