# SPDX-License-Identifier: GPL-3.0-or-later
"""From the numbers in the files to physical quantities, and the checks of their ranges. No bpy.

Rasters are array('f'), `channels` values a pixel, row 0 at the bottom (Blender's order). Nothing is decoded where
the mask is 0. Throws InputError.
"""
import math
from array import array
from itertools import compress

from . import vector
from .errors import InputError

SLACK = 0.01            # beyond [0, 1]: clamped, above that refused
NORMAL_LENGTH = (0.8, 1.2)


def srgb_to_linear(value):
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4


def linear_to_srgb(value):
    return value * 12.92 if value <= 0.0031308 else 1.055 * value ** (1 / 2.4) - 0.055


F0_OF = {
    "srgb_f0": srgb_to_linear,
    "disney08": lambda value: 0.08 * value,
    "linear_f0": lambda value: value,
}


def covered_pixels(mask):
    """Indices of the pixels of which something is covered."""
    if vector.np:
        return vector.np.flatnonzero(vector.view(mask) > 0)
    return list(compress(range(len(mask)), [value > 0 for value in mask]))


def covered(mask):
    """bytearray: 1 where something of a pixel is covered, else 0."""
    if vector.np:
        return bytearray((vector.view(mask) > 0).tobytes())
    return bytearray(value > 0 for value in mask)


def check_finite(values, channels, pixels, width, height, path):
    """All values of the given pixels are finite, or InputError names the first that is not."""
    if vector.np and vector.is_finite(values, channels, pixels):
        return
    isfinite = math.isfinite
    for p in pixels:
        for c in range(channels):
            if not isfinite(values[p * channels + c]):
                raise InputError(path, "pixel (%d, %d)" % (p % width, height - 1 - p // width),
                                 "is NaN or infinite", "write the map again")


def clamp_unit(values, channels, pixels, width, height, path):
    """Clamps to [0, 1] in place; more than SLACK outside is an error."""
    if vector.np and vector.clamp_unit(values, channels, pixels, SLACK):
        return
    for p in pixels:
        for i in range(p * channels, (p + 1) * channels):
            value = values[i]
            if value < 0 or value > 1:
                if not -SLACK <= value <= 1 + SLACK:
                    raise InputError(path, "pixel (%d, %d)" % (p % width, height - 1 - p // width),
                                     "has the value %.4g, outside [0, 1]" % value,
                                     "correct the map or its encoding in maps.json")
                values[i] = min(max(value, 0.0), 1.0)


def decode_each(values, channels, pixels, function):
    """Applies a function to the values of the given pixels, in place; equal values are computed once."""
    if vector.np:
        vector.decode_each(values, channels, pixels, vector.srgb_to_linear if function is srgb_to_linear else function)
        return
    known = {}
    for p in pixels:
        for i in range(p * channels, (p + 1) * channels):
            value = values[i]
            result = known.get(value)
            if result is None:
                result = known[value] = function(value)
            values[i] = result


def _unit_normals(values, pixels, scale, shift):
    """Unit normals in place; returns (median length before, how many look away)."""
    lengths, away = [], 0
    for p in pixels:
        i = 3 * p
        x, y, z = values[i] * scale + shift, values[i + 1] * scale + shift, values[i + 2] * scale + shift
        length = math.sqrt(x * x + y * y + z * z)
        lengths.append(length)
        away += z < 0
        if length < 1e-6:
            x, y, z, length = 0.0, 0.0, 1.0, 1.0
        values[i], values[i + 1], values[i + 2] = x / length, y / length, z / length
    return sorted(lengths)[len(lengths) // 2], away


def decode_normals(values, pixels, encoding, path):
    """Unit normals in place; InputError if they were evidently written in another encoding."""
    scale, shift = (2.0, -1.0) if encoding == "offset" else (1.0, 0.0)
    median, away = (vector.decode_normals if vector.np else _unit_normals)(values, pixels, scale, shift)
    if not NORMAL_LENGTH[0] <= median <= NORMAL_LENGTH[1]:
        raise InputError(path, "", "its normals have a median length of %.2f, read as '%s'" % (median, encoding),
                         "correct maps.normal.encoding in maps.json")
    if 2 * away > len(pixels):
        raise InputError(path, "", "most normals point away from the viewer, read as '%s'" % encoding,
                         "correct maps.normal.encoding, or the axes: +Z is to the viewer")


def decode_displacement(values, pixels, encoding, r_cm, camera, width, height, path):
    """Signed cm from the centre plane, in place."""
    limit = camera.distance_cm if camera.type == "perspective" else math.inf
    if vector.np and vector.decode_displacement(values, pixels, encoding == "offset", r_cm, limit):
        return
    for p in pixels:
        depth = (values[p] - 0.5) * 2 * r_cm if encoding == "offset" else values[p]
        if depth >= limit:
            raise InputError(path, "pixel (%d, %d)" % (p % width, height - 1 - p // width),
                             "lies %.4g cm in front of the centre plane, behind the camera at %.4g cm"
                             % (depth, limit), "correct r_cm or camera.distance_cm in maps.json")
        values[p] = depth


def grow(values, channels, known, width, height, steps):
    """Fills pixels next to known ones with the mean of those, `steps` times, in place, so that interpolation at
    the person's outline never meets the background. known: bytearray, 1 where values hold; is grown too."""
    if vector.np:
        vector.grow(values, channels, known, width, height, steps)
        return
    border = [p for p in range(width * height) if known[p]]
    for _ in range(steps):
        sums = {}
        for p in border:
            for q in neighbours(p, width, height):
                if not known[q]:
                    sums.setdefault(q, []).append(p)
        for q, sources in sums.items():
            for c in range(channels):
                values[q * channels + c] = sum(values[p * channels + c] for p in sources) / len(sources)
        for q in sums:
            known[q] = 1
        border = list(sums)


LEAST_AGREEMENT = 0.3   # correlation of slopes that is no chance


def check_green_up(normals, depth_cm, pixels, known, width, height, path):
    """Throws InputError where normals agree with the displacement from left to right and contradict it from bottom
    to top: their green channel points down, as DirectX has it."""
    across, up = vector.slopes(normals, depth_cm, known, width, height) if vector.np else \
        _slopes(normals, depth_cm, pixels, known, width, height)
    if agreement(across) > LEAST_AGREEMENT and agreement(up) < -LEAST_AGREEMENT:
        raise InputError(path, "", "its green channel points down (DirectX): it contradicts the displacement",
                         "invert the green channel: +Y is up")


def _slopes(normals, depth_cm, pixels, known, width, height):
    """Pairs of slopes (of the depth, of the normal) across and up, of the pixels that have all four neighbours."""
    across, up = [], []
    for p in pixels:
        x, y = p % width, p // width
        nz = normals[3 * p + 2]
        if not (0 < x < width - 1 and 0 < y < height - 1 and nz > 0.3):
            continue
        if known[p - 1] and known[p + 1] and known[p - width] and known[p + width]:
            across.append((depth_cm[p + 1] - depth_cm[p - 1], -normals[3 * p] / nz))
            up.append((depth_cm[p + width] - depth_cm[p - width], -normals[3 * p + 1] / nz))
    return across, up


def agreement(pairs):
    """Correlation of pairs of slopes, each cut off at its tenfold median: edges have any slope."""
    if len(pairs) < 16:
        return 0.0
    if vector.np:
        return vector.agreement(pairs)
    limits = [10 * sorted(abs(pair[k]) for pair in pairs)[len(pairs) // 2] for k in (0, 1)]
    cut = [[min(max(pair[k], -limits[k]), limits[k]) for pair in pairs] for k in (0, 1)]
    product = sum(a * b for a, b in zip(*cut))
    size = math.sqrt(sum(a * a for a in cut[0]) * sum(b * b for b in cut[1]))
    return product / size if size > 0 else 0.0


PIT_PX = 2     # pits of at most so many pixels across are mended ...
PIT_CM = 1.0   # ... that are deeper than this


def mend_pits(depth_cm, known, width, height):
    """Fills isolated pits, in place. A pixel on an edge holds the mean of near and far, where nothing is (the corner
    of a mouth, a gap between strands of hair): a hole there is black under any light. A pit is closed in along rows,
    columns and both diagonals, so slopes, steps, creases and the person's outline stay."""
    if vector.np:
        vector.mend_pits(depth_cm, known, width, height, PIT_PX, PIT_CM)
        return
    filled = {}
    for p in range(width * height):
        if known[p]:
            bottom = depth_cm[p] + PIT_CM
            levels = []
            for dx, dy in ((1, 0), (0, 1), (1, 1), (1, -1)):
                levels.append(_closed(depth_cm, known, p, dx, dy, width, height))
                if levels[-1] <= bottom:
                    break
            else:
                filled[p] = min(levels)
    for p, level in filled.items():
        depth_cm[p] = level


def _closed(depth_cm, known, p, dx, dy, width, height):
    """Morphological closing by a segment of PIT_PX + 1 pixels in one direction: the lowest of the segments through
    p, each counting as its highest known pixel."""
    x, y = p % width, p // width
    line = []
    for step in range(-PIT_PX, PIT_PX + 1):
        u, v = x + step * dx, y + step * dy
        inside = 0 <= u < width and 0 <= v < height and known[v * width + u]
        line.append(depth_cm[v * width + u] if inside else -math.inf)
    return min(max(line[i:i + PIT_PX + 1]) for i in range(PIT_PX + 1))


MIN_FACING = 0.2   # normals are taken to look at the viewer at least so much
MOST_FALL_CM = 4.0   # of a pixel beyond the outline: more than a depth jump would be cut


def grow_depth(depth_cm, normals, known, width, height, steps, pixel_cm):
    """Like grow, but the surface goes on and turns away from the viewer as the person does, so that light from the
    side and from behind reaches it. From a pixel whose normal looks at the viewer by c = cos a, a round body falls
    by (1 + sin a) / c for each unit of the way to its outline: more than its tangent plane. Normals are grown
    already."""
    if vector.np:
        vector.grow_depth(depth_cm, normals, known, width, height, steps, pixel_cm, MIN_FACING, MOST_FALL_CM)
        return
    border = [p for p in range(width * height) if known[p]]
    for _ in range(steps):
        found = {}
        for p in border:
            nx, ny, nz = normals[3 * p:3 * p + 3]
            facing = max(nz, MIN_FACING) / pixel_cm
            side = math.hypot(nx, ny)
            turn = (1 + side) / side if side > 1e-6 else 1.0
            for q in neighbours(p, width, height):
                if not known[q]:
                    right, up = q % width - p % width, q // width - p // width
                    fall_cm = (nx * right + ny * up) / facing
                    fall_cm = min(turn * fall_cm, MOST_FALL_CM) if fall_cm > 0 else fall_cm
                    found.setdefault(q, []).append(depth_cm[p] - fall_cm)
        for q, depths in found.items():
            depth_cm[q] = sum(depths) / len(depths)
            known[q] = 1
        border = list(found)


def turn_away(normals, mask, known):
    """Beyond the outline normals look away from the viewer, mirrored at the picture's plane: interpolated, those of a
    pixel at the outline turn within it until they look sideways, as on a round body."""
    if vector.np:
        vector.turn_away(normals, mask, known)
        return
    for p in range(len(mask)):
        if known[p] and not mask[p] > 0:
            normals[3 * p + 2] = -normals[3 * p + 2]


def neighbours(p, width, height):
    """The up to eight pixels around p."""
    x, y = p % width, p // width
    return [v * width + u
            for v in range(max(y - 1, 0), min(y + 2, height))
            for u in range(max(x - 1, 0), min(x + 2, width)) if (u, v) != (x, y)]


def luminance(r, g, b):
    """Rec. 709."""
    return 0.2126 * r + 0.7152 * g + 0.0722 * b


def zeros(count):
    return array("f", bytes(4 * count))
