# SPDX-License-Identifier: GPL-3.0-or-later
"""Sets of faces that one click or lasso means: a material, a connected piece, a UV island. No bpy."""
from collections import defaultdict


class Faces:
    """The faces of a scan by their corners: array('i') of first corners (faces + 1), vertices, and UVs (2 a corner)."""

    def __init__(self, first_corner, vertices, uvs, materials):
        self.first_corner, self.vertices, self.uvs, self.materials = first_corner, vertices, uvs, materials
        self._faces_of = {}   # kind -> key of a corner -> faces

    def __len__(self):
        return len(self.first_corner) - 1

    def corners(self, face):
        return range(self.first_corner[face], self.first_corner[face + 1])

    def of_material(self, face):
        wanted = self.materials[face]
        return [f for f, m in enumerate(self.materials) if m == wanted]

    def of_piece(self, face):
        """All that share vertices with it, from face to face."""
        return self._flood(face, "piece", self.vertices.__getitem__)

    def of_island(self, face):
        """All that share vertices with it in the UV layout too."""
        uvs = self.uvs
        return self._flood(face, "island", lambda c: (self.vertices[c], uvs[2 * c], uvs[2 * c + 1]))

    def _flood(self, face, kind, key_of):
        if kind not in self._faces_of:
            faces_of = self._faces_of[kind] = defaultdict(list)
            for f in range(len(self)):
                for c in self.corners(f):
                    faces_of[key_of(c)].append(f)
        faces_of = self._faces_of[kind]
        found, keys, front = {face}, set(), [face]
        while front:
            for key in map(key_of, self.corners(front.pop())):
                if key not in keys:
                    keys.add(key)
                    new = [f for f in faces_of[key] if f not in found]
                    found.update(new)
                    front += new
        return sorted(found)


def is_inside(x, y, polygon):
    """Whether a place of the window is inside a lasso (even-odd rule)."""
    inside = False
    for (ax, ay), (bx, by) in zip(polygon, polygon[1:] + polygon[:1]):
        if (ay > y) != (by > y) and x < ax + (y - ay) * (bx - ax) / (by - ay):
            inside = not inside
    return inside
