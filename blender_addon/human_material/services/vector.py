# SPDX-License-Identifier: GPL-3.0-or-later
"""The same steps as in decode.py, classes.py and grid.py for whole rasters at once, where NumPy is there (in Blender's
own builds, not in Debian's). Rasters are array('f') here too and are changed in place; pixels may be a NumPy array.
Functions that check return False where something is wrong: the caller then looks for the place. No bpy."""
try:
    import numpy as np
except ImportError:   # all that is needed is written in plain Python as well
    np = None

AROUND = tuple((dx, dy) for dy in (-1, 0, 1) for dx in (-1, 0, 1) if (dx, dy) != (0, 0))


def view(values, channels=1):
    """An array('f') or bytearray as a NumPy array of (pixels, channels) that shares its memory."""
    flat = np.frombuffer(values, np.uint8 if isinstance(values, (bytearray, bytes)) else np.float32)
    return flat.reshape(-1, channels) if channels > 1 else flat


def is_finite(values, channels, pixels):
    return bool(np.isfinite(view(values, channels)[pixels]).all())


def clamp_unit(values, channels, pixels, slack):
    a = view(values, channels)
    found = a[pixels]
    if found.size and not (found.min() >= -slack and found.max() <= 1 + slack):
        return False
    a[pixels] = np.clip(found, 0, 1)
    return True


def srgb_to_linear(value):
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def linear_to_srgb(value):
    return np.where(value <= 0.0031308, value * 12.92, 1.055 * np.maximum(value, 0) ** (1 / 2.4) - 0.055)


def decode_each(values, channels, pixels, function):
    a = view(values, channels)
    a[pixels] = function(a[pixels].astype(np.float64))


def decode_normals(values, pixels, scale, shift):
    """Unit normals in place; returns (median length before, how many look away)."""
    a = view(values, 3)
    n = a[pixels].astype(np.float64) * scale + shift
    length = np.sqrt((n * n).sum(1))
    away = int((n[:, 2] < 0).sum())
    n[length < 1e-6] = (0, 0, 1)
    a[pixels] = n / np.where(length < 1e-6, 1, length)[:, None]
    return float(np.sort(length)[len(length) // 2]), away


def decode_displacement(values, pixels, is_offset, r_cm, limit):
    a = view(values)
    depth = a[pixels].astype(np.float64)
    if is_offset:
        depth = (depth - 0.5) * 2 * r_cm
    if (depth >= limit).any():
        return False
    a[pixels] = depth
    return True


def slopes(normals, depth_cm, known, width, height):
    """Pairs of slopes (of the depth, of the normal) across and up, of the pixels that have all four neighbours."""
    n = view(normals, 3).reshape(height, width, 3)
    depth = view(depth_cm).reshape(height, width)
    inside = np.array(known, bool).reshape(height, width)
    ok = (inside[1:-1, 1:-1] & inside[1:-1, :-2] & inside[1:-1, 2:] & inside[:-2, 1:-1] & inside[2:, 1:-1]
          & (n[1:-1, 1:-1, 2] > 0.3))
    nx, ny, nz = (n[1:-1, 1:-1, c][ok].astype(np.float64) for c in range(3))
    across = (depth[1:-1, 2:] - depth[1:-1, :-2])[ok]
    up = (depth[2:, 1:-1] - depth[:-2, 1:-1])[ok]
    return np.stack([across, -nx / nz], 1), np.stack([up, -ny / nz], 1)


def agreement(pairs):
    pairs = np.asarray(pairs, np.float64)
    limits = 10 * np.sort(abs(pairs), 0)[len(pairs) // 2]
    cut = np.clip(pairs, -limits, limits)
    size = float(np.sqrt((cut * cut).sum(0).prod()))
    return float(cut.prod(1).sum()) / size if size > 0 else 0.0


def mend_pits(depth_cm, known, width, height, pit_px, pit_cm):
    depth = view(depth_cm).reshape(height, width)
    inside = view(known).reshape(height, width) > 0
    pad = pit_px
    framed = np.full((height + 2 * pad, width + 2 * pad), -np.inf, np.float32)
    framed[pad:-pad, pad:-pad] = np.where(inside, depth, -np.inf)
    level = np.full((height, width), np.inf, np.float32)
    for dx, dy in ((1, 0), (0, 1), (1, 1), (1, -1)):
        line = [framed[pad + k * dy:pad + k * dy + height, pad + k * dx:pad + k * dx + width]
                for k in range(-pad, pad + 1)]
        for first in range(pad + 1):
            level_here = np.maximum.reduce(line[first:first + pad + 1])
            lowest = level_here if first == 0 else np.minimum(lowest, level_here)
        np.minimum(level, lowest, out=level)
    pit = inside & (level > depth + np.float32(pit_cm))
    depth[pit] = level[pit]


def _next_ring(border, known, width, height):
    """Unknown pixels beside the border, and of each the border pixels around it: (q, [(source, is one, dx, dy)])."""
    beside = np.zeros((height, width), bool)
    flat = border.reshape(height, width)
    for dx, dy in AROUND:
        beside[max(dy, 0):height + min(dy, 0), max(dx, 0):width + min(dx, 0)] |= \
            flat[max(-dy, 0):height + min(-dy, 0), max(-dx, 0):width + min(-dx, 0)]
    q = np.flatnonzero(beside.ravel() & ~known)
    x, y = q % width, q // width
    sources = []
    for dx, dy in AROUND:   # the source lies at (x - dx, y - dy)
        u, v = x - dx, y - dy
        ok = (u >= 0) & (u < width) & (v >= 0) & (v < height)
        p = np.where(ok, v * width + u, 0)
        sources.append((p, ok & border[p], dx, dy))
    return q, sources


def grow(values, channels, known, width, height, steps):
    a, is_known = view(values, channels).reshape(-1, channels), view(known) > 0
    border = is_known.copy()
    for _ in range(steps):
        q, sources = _next_ring(border, is_known, width, height)
        total, count = np.zeros((len(q), channels)), np.zeros(len(q))
        for p, is_one, _dx, _dy in sources:
            total += np.where(is_one[:, None], a[p], 0)
            count += is_one
        a[q] = total / np.maximum(count, 1)[:, None]
        border = np.zeros_like(border)
        border[q] = True
        is_known |= border
    view(known)[:] = is_known


def grow_depth(depth_cm, normals, known, width, height, steps, pixel_cm, min_facing, most_fall_cm):
    depth, n, is_known = view(depth_cm), view(normals, 3), view(known) > 0
    border = is_known.copy()
    for _ in range(steps):
        q, sources = _next_ring(border, is_known, width, height)
        total, count = np.zeros(len(q)), np.zeros(len(q))
        for p, is_one, dx, dy in sources:
            nx, ny, nz = n[p].astype(np.float64).T
            side = np.hypot(nx, ny)
            turn = np.where(side > 1e-6, (1 + side) / np.maximum(side, 1e-6), 1.0)
            fall = (nx * dx + ny * dy) * pixel_cm / np.maximum(nz, min_facing)
            fall = np.where(fall > 0, np.minimum(turn * fall, most_fall_cm), fall)
            total += np.where(is_one, depth[p] - fall, 0)
            count += is_one
        depth[q] = total / np.maximum(count, 1)
        border = np.zeros_like(border)
        border[q] = True
        is_known |= border
    view(known)[:] = is_known


def turn_away(normals, mask, known):
    n = view(normals, 3)
    n[(view(known) > 0) & ~(view(mask) > 0), 2] *= -1


def nearest_classes(points, features, nothing, pixels, size):
    """bytearray of the nearest class of each pixel; points: (pixels, 3)."""
    distance = np.stack([((points - np.array(f)) ** 2).sum(1) for f in features])
    result = bytearray([nothing]) * size
    view(result)[pixels] = distance.argmin(0)
    return result


def windows(labels, count, width, height, radius):
    """(count, height, width): how many pixels of each class the square around a pixel holds, cut at the frame."""
    flat = view(labels).reshape(height, width)
    result = np.zeros((count, height, width), np.uint8)
    for c in range(count):
        framed = np.pad((flat == c).astype(np.uint8), radius)
        rows = sum(framed[:, k:k + width] for k in range(2 * radius + 1))
        result[c] = sum(rows[k:k + height] for k in range(2 * radius + 1))
    return result


def vote(labels, pixels, count, width, height, radius):
    """Each pixel takes the class of most pixels around it; on a tie it keeps its own."""
    counts = windows(labels, count, width, height, radius).reshape(count, -1)[:, pixels].astype(np.int16)
    own = view(labels)[pixels]
    counts *= 2
    counts[own, np.arange(len(own))] += 1
    result = bytearray(labels)
    view(result)[pixels] = counts.argmax(0)
    return result


def quads(displacement_cm, known, width, height, jump_cm):
    """Corners (n, 4) of the squares whose four pixels are known: (those of one sheet, those to be cut)."""
    depth = view(displacement_cm).reshape(height, width).astype(np.float64)
    inside = view(known).reshape(height, width) > 0
    corners = (slice(0, -1), slice(0, -1)), (slice(0, -1), slice(1, None)), (slice(1, None), slice(1, None)), \
        (slice(1, None), slice(0, -1))
    whole = np.logical_and.reduce([inside[c] for c in corners])
    spread = np.maximum.reduce([depth[c] for c in corners]) - np.minimum.reduce([depth[c] for c in corners])
    y, x = np.nonzero(whole)
    p = y * width + x
    result = np.stack([p, p + 1, p + width + 1, p + width], 1)
    one = spread[y, x] <= jump_cm
    return result[one], result[~one]
