# SPDX-License-Identifier: GPL-3.0-or-later
"""The side that the maps do not show, guessed for the shadows that it throws. No bpy.

A row (or a column) of covered cells is a cut through a limb or the trunk. Its middle is taken to run straight from the
depth of the one outline to that of the other, and the back is as far behind the middle as the front is before it; but a
cut is at least as thick as it is wide, as limbs are, and where it is wider than THICKEST_CM, as the trunk is, as thick
as that. Cells are some pixels wide: a shadow's edge needs no more.
"""
import math

from . import grid

CELLS = 160          # along the frame's longer side
LOOKED_AT = 4        # pixels of a cell, along a side
COVERED = 0.5
THICKEST_CM = 22.0   # that width alone tells


def depths(displacement_cm, mask, width, height, pixel_cm):
    """({(column, row): depth of the back in cm}, pixels along a cell's side). Rasters have row 0 at the bottom."""
    side = max(1, -(-max(width, height) // CELLS))
    front = _cells(displacement_cm, mask, width, height, side)
    rows, columns = _middles(front, 0), _middles(front, 1)
    back = {}
    for cell, z in front.items():
        cuts = rows[cell], columns[cell]
        middle = sum(m / n ** 2 for m, n, _ in cuts) / sum(1 / n ** 2 for _, n, _ in cuts)   # the shorter cut tells more
        _, count, t = min(cuts, key=lambda cut: cut[1])
        thickness = min(count * side * pixel_cm, THICKEST_CM) * math.sqrt(max(0.0, 1 - (2 * t - 1) ** 2))
        back[cell] = min(middle - max(z - middle, 0.0), z - thickness, z - pixel_cm)
    return back, side


def _cells(displacement_cm, mask, width, height, side):
    """Mean depth of the cells that are covered by half or more."""
    cells, step = {}, max(1, side // LOOKED_AT)
    for row in range(0, height, side):
        for column in range(0, width, side):
            total = count = pixels = 0
            for y in range(row, min(row + side, height), step):
                for p in range(y * width + column, y * width + min(column + side, width), step):
                    pixels += 1
                    if mask[p] > COVERED:
                        total += displacement_cm[p]
                        count += 1
            if 2 * count >= pixels:
                cells[column // side, row // side] = total / count
    return cells


def _middles(front, axis):
    """cell -> (depth of the middle, cells of its cut, where in it from 0 to 1), along rows (axis 0) or columns (1)."""
    lines = {}
    for cell in front:
        lines.setdefault(cell[1 - axis], []).append(cell[axis])
    found = {}
    for line, places in lines.items():
        for run in _runs(sorted(places)):
            cells = [(k, line) if axis == 0 else (line, k) for k in run]
            first, last = front[cells[0]], front[cells[-1]]
            for k, cell in enumerate(cells):
                t = (k + 0.5) / len(cells)
                found[cell] = first + t * (last - first), len(cells), t
    return found


def _runs(places):
    run = [places[0]]
    for place in places[1:]:
        if place != run[-1] + 1:
            yield run
            run = []
        run.append(place)
    yield run


def build(loaded):
    """A grid.Relief of the back, in the axes of grid.build; its faces are counter-clockwise seen from behind."""
    width, height = loaded.size
    camera = loaded.info.camera
    frame = grid.Frame(camera, width, height)
    found, side = depths(loaded.displacement_cm, loaded.mask, width, height, frame.pixel_cm)
    relief, index = grid.Relief(), {}
    for (column, row), z in found.items():
        x, y = (column + 0.5) * side - 0.5, (row + 0.5) * side - 0.5
        index[column, row] = len(relief.vertices)
        relief.vertices.append(frame.point(x, y, z))
        relief.uvs.append(frame.uv(x, y))
    for column, row in found:
        corners = [(column, row), (column, row + 1), (column + 1, row + 1), (column + 1, row)]
        if all(corner in index for corner in corners):
            relief.faces.append(tuple(index[corner] for corner in corners))
    return relief
