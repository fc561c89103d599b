# SPDX-License-Identifier: GPL-3.0-or-later
"""From the numbers in the files to physical quantities, and the checks of their ranges. No bpy.

Rasters are array('f'), `channels` values a pixel, row 0 at the bottom (Blender's order). Nothing is decoded where
the mask is 0. Throws InputError.
"""
import math
from array import array
from itertools import compress

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
    return list(compress(range(len(mask)), [value > 0 for value in mask]))


def check_finite(values, channels, pixels, width, height, path):
    """All values of the given pixels are finite, or InputError names the first that is not."""
    isfinite = math.isfinite
    for p in pixels:
        for c in range(channels):
            if not isfinite(values[p * channels + c]):
                raise InputError(path, "pixel (%d, %d)" % (p % width, height - 1 - p // width),
                                 "is NaN or infinite", "write the map again")


def clamp_unit(values, channels, pixels, width, height, path):
    """Clamps to [0, 1] in place; more than SLACK outside is an error."""
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
    known = {}
    for p in pixels:
        for i in range(p * channels, (p + 1) * channels):
            value = values[i]
            result = known.get(value)
            if result is None:
                result = known[value] = function(value)
            values[i] = result


def decode_normals(values, pixels, encoding, path):
    """Unit normals in place; InputError if they were evidently written in another encoding."""
    lengths, away = [], 0
    scale, shift = (2.0, -1.0) if encoding == "offset" else (1.0, 0.0)
    for p in pixels:
        i = 3 * p
        x, y, z = values[i] * scale + shift, values[i + 1] * scale + shift, values[i + 2] * scale + shift
        length = math.sqrt(x * x + y * y + z * z)
        lengths.append(length)
        away += z < 0
        if length < 1e-6:
            x, y, z, length = 0.0, 0.0, 1.0, 1.0
        values[i], values[i + 1], values[i + 2] = x / length, y / length, z / length
    median = sorted(lengths)[len(lengths) // 2]
    if not NORMAL_LENGTH[0] <= median <= NORMAL_LENGTH[1]:
        raise InputError(path, "", "its normals have a median length of %.2f, read as '%s'" % (median, encoding),
                         "correct maps.normal.encoding in maps.json")
    if 2 * away > len(pixels):
        raise InputError(path, "", "most normals point away from the viewer, read as '%s'" % encoding,
                         "correct maps.normal.encoding, or the axes: +Z is to the viewer")


def decode_displacement(values, pixels, encoding, r_cm, camera, width, height, path):
    """Signed cm from the centre plane, in place."""
    limit = camera.distance_cm if camera.type == "perspective" else math.inf
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


MIN_FACING = 0.2   # normals are taken to look at the viewer at least so much: slopes of at most 5


def grow_depth(depth_cm, normals, known, width, height, steps, pixel_cm):
    """Like grow, but the surface goes on along its own tangent planes: at the outline it turns away from the viewer
    as the person does, so that light from the side and from behind reaches it. Normals are grown already."""
    border = [p for p in range(width * height) if known[p]]
    for _ in range(steps):
        found = {}
        for p in border:
            nx, ny, nz = normals[3 * p:3 * p + 3]
            facing = max(nz, MIN_FACING) / pixel_cm
            for q in neighbours(p, width, height):
                if not known[q]:
                    right, up = q % width - p % width, q // width - p // width
                    found.setdefault(q, []).append(depth_cm[p] - (nx * right + ny * up) / facing)
        for q, depths in found.items():
            depth_cm[q] = sum(depths) / len(depths)
            known[q] = 1
        border = list(found)


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
