# SPDX-License-Identifier: GPL-3.0-or-later
"""The relief: a mesh with one vertex a pixel that is exactly the displacement map, cut at depth jumps. No bpy.

Local axes are the camera's (+X right, +Y up, +Z to the viewer), origin in the middle of the frame on the centre
plane, metres. A vertex lies on the view ray of its pixel's centre at the pixel's displacement, so that the camera of
maps.json sees the maps as they are.

Where neighbours differ in depth by more than a limit, the surface is not one: no rubber sheet is drawn. Instead each
sheet goes on at its own depth: the farthest by a whole pixel behind the others, those by half a pixel. So no crack
shows the background, and the pixels' centres stay exact.
"""
from dataclasses import dataclass, field

from . import vector

CM = 0.01   # in metres
DEFAULT_JUMP_CM = 5.0


@dataclass
class Relief:
    vertices: list = field(default_factory=list)   # (x, y, z), metres
    uvs: list = field(default_factory=list)        # of each vertex; (0, 0) is the frame's lower left corner
    faces: list = field(default_factory=list)      # quads of vertex indices, counter-clockwise to the viewer
    pixel_vertices: int = 0                        # the first so many are pixels; the rest are the sheets' edges


class Frame:
    """From pixel coordinates (row 0 at the bottom) and depth to points and texture coordinates."""

    def __init__(self, camera, width, height):
        self.camera, self.width, self.height = camera, width, height
        self.pixel_cm = camera.frame_width_cm / width

    def point(self, x, y, z_cm):
        scale = self.camera.scale_at(z_cm) * self.pixel_cm * CM
        return (x + 0.5 - 0.5 * self.width) * scale, (y + 0.5 - 0.5 * self.height) * scale, z_cm * CM

    def uv(self, x, y):
        return (x + 0.5) / self.width, (y + 0.5) / self.height


def build(displacement_cm, known, width, height, camera, jump_cm=DEFAULT_JUMP_CM):
    """The Relief of the pixels where `known` is 1."""
    frame = Frame(camera, width, height)
    if vector.np:
        return _build_fast(displacement_cm, known, frame, jump_cm)
    relief = Relief()
    index = {}
    for p in range(width * height):
        if known[p]:
            x, y = p % width, p // width
            index[p] = len(relief.vertices)
            relief.vertices.append(frame.point(x, y, displacement_cm[p]))
            relief.uvs.append(frame.uv(x, y))
    relief.pixel_vertices = len(relief.vertices)
    for y in range(height - 1):
        for p in range(y * width, y * width + width - 1):
            corners = (p, p + 1, p + width + 1, p + width)
            if not (known[p] and known[p + 1] and known[p + width + 1] and known[p + width]):
                continue
            depths = [displacement_cm[q] for q in corners]
            if max(depths) - min(depths) <= jump_cm:
                relief.faces.append(tuple(index[q] for q in corners))
            else:
                _add_cut_quad(relief, frame, p % width, y, [index[q] for q in corners], depths, jump_cm)
    return relief


def _build_fast(displacement_cm, known, frame, jump_cm):
    """The same by NumPy; the faces of one sheet come first."""
    np, width = vector.np, frame.width
    pixels = np.flatnonzero(vector.view(known) > 0)
    x, y = pixels % width, pixels // width
    vertices = np.stack(frame.point(x, y, vector.view(displacement_cm)[pixels].astype(float)), 1)
    relief = Relief(vertices.tolist(), np.stack(frame.uv(x, y), 1).tolist(), [], len(pixels))
    index = np.zeros(len(known), np.int64)
    index[pixels] = np.arange(len(pixels))
    whole, cut = vector.quads(displacement_cm, known, width, frame.height, jump_cm)
    relief.faces = index[whole].tolist()
    for corners in cut.tolist():
        _add_cut_quad(relief, frame, corners[0] % width, corners[0] // width, [int(index[q]) for q in corners],
                      [displacement_cm[q] for q in corners], jump_cm)
    return relief


CORNERS = ((0, 0), (1, 0), (1, 1), (0, 1))   # of a quad, counter-clockwise


def sheets(depths, jump_cm):
    """Corners (0 to 3) of each sheet of a quad, the nearest sheet first: split at the gaps above the limit."""
    order = sorted(range(4), key=lambda c: -depths[c])
    result = [[order[0]]]
    for before, corner in zip(order, order[1:]):
        if depths[before] - depths[corner] > jump_cm:
            result.append([])
        result[-1].append(corner)
    return result


def _add_cut_quad(relief, frame, x, y, indices, depths, jump_cm):
    *front, back = sheets(depths, jump_cm)
    if not front:   # a slope of small steps: one sheet after all
        relief.faces.append(tuple(indices))
        return
    for sheet in front:
        _add_half(relief, frame, x, y, indices, depths, sheet)
    mean = sum(depths[c] for c in back) / len(back)
    relief.faces.append(tuple(
        indices[c] if c in back else _vertex(relief, frame, x + CORNERS[c][0], y + CORNERS[c][1], mean)
        for c in range(4)))


def _add_half(relief, frame, x, y, indices, depths, sheet):
    """The quarters of a quad next to the corners of a sheet."""
    mean = sum(depths[c] for c in sheet) / len(sheet)
    middle = _vertex(relief, frame, x + 0.5, y + 0.5, mean)
    sides = {}
    for c in sheet:
        for a, b in ((c, (c + 1) % 4), ((c - 1) % 4, c)):
            if (a, b) not in sides:
                ends = [depths[e] for e in (a, b) if e in sheet]
                sides[a, b] = _vertex(relief, frame, x + 0.5 * (CORNERS[a][0] + CORNERS[b][0]),
                                      y + 0.5 * (CORNERS[a][1] + CORNERS[b][1]), sum(ends) / len(ends))
        relief.faces.append((indices[c], sides[c, (c + 1) % 4], middle, sides[(c - 1) % 4, c]))


def _vertex(relief, frame, x, y, z_cm):
    relief.vertices.append(frame.point(x, y, z_cm))
    relief.uvs.append(frame.uv(x, y))
    return len(relief.vertices) - 1
