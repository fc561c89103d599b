# SPDX-License-Identifier: Apache-2.0
"""Signed-distance building blocks: noise, blends and primitives.

All lengths are centimetres. A "field" takes points of shape (N, 3) and gives
N signed distances, negative inside. Distances need not be exact: only the zero
set and a slope near one matter to the mesher.
"""
import numpy as np

F32 = np.float32
_TILE = 128          # edge of the periodic noise tile, in voxels
_FEATURE = 8         # voxels per noise feature


def _make_noise_tile():
    """Band-limited Gaussian noise: it has no lattice pattern, unlike value noise."""
    rng = np.random.RandomState(20231107)
    spectrum = np.fft.fftn(rng.standard_normal((_TILE,) * 3))
    k = np.fft.fftfreq(_TILE)
    radius = np.sqrt(k[:, None, None] ** 2 + k[None, :, None] ** 2 + k[None, None, :] ** 2)
    centre = 0.5 / _FEATURE
    spectrum *= np.exp(-((radius - centre) / (0.35 * centre)) ** 2)
    tile = np.real(np.fft.ifftn(spectrum))
    return (tile / tile.std() * 0.4).astype(F32)


_NOISE = _make_noise_tile().ravel()


def noise(p, per_cm, seed=0):
    """Smooth noise, about -1..1. `per_cm`: features per cm (one number or one per axis)."""
    q = p * (np.asarray(per_cm, F32) * _FEATURE)
    q = q + np.array([17.3, 41.7, 73.1], F32) * (seed + 1)
    base = np.floor(q)
    f = (q - base).astype(F32)
    i = base.astype(np.int32) & (_TILE - 1)
    j = (i + 1) & (_TILE - 1)
    x = (i[:, 0] * (_TILE * _TILE), j[:, 0] * (_TILE * _TILE))
    y = (i[:, 1] * _TILE, j[:, 1] * _TILE)
    z = (i[:, 2], j[:, 2])
    total = np.zeros(len(p), F32)
    for a in (0, 1):
        wx = f[:, 0] if a else 1 - f[:, 0]
        for b in (0, 1):
            wxy = wx * (f[:, 1] if b else 1 - f[:, 1])
            row = x[a] + y[b]
            total += wxy * (_NOISE[row + z[0]] * (1 - f[:, 2]) + _NOISE[row + z[1]] * f[:, 2])
    return total


def fbm(p, per_cm, octaves, seed=0):
    """Sum of octaves, each half as strong and twice as fine."""
    per_cm = np.asarray(per_cm, F32)
    total, gain = 0.0, 1.0
    for octave in range(octaves):
        total = total + gain * noise(p, per_cm * 2 ** octave, seed + 7 * octave)
        gain *= 0.5
    return total


def smoothstep(low, high, x):
    t = np.clip((x - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def gauss(x):
    return np.exp(-x * x)


def smin(a, b, k):
    """Union with a fillet of about k cm."""
    h = np.clip(0.5 + 0.5 * (b - a) / k, 0, 1)
    return b + (a - b) * h - k * h * (1 - h)


def smax(a, b, k):
    return -smin(-a, -b, k)


def sphere(p, centre, radius):
    return np.sqrt(((p - np.asarray(centre, F32)) ** 2).sum(1)) - F32(radius)


def ellipsoid(p, centre, radii):
    q = p - np.asarray(centre, F32)
    radii = np.asarray(radii, F32)
    k0 = np.sqrt(((q / radii) ** 2).sum(1))
    k1 = np.sqrt(((q / radii ** 2) ** 2).sum(1)) + 1e-6
    return k0 * (k0 - 1) / k1


def capsule(p, a, b, radius_a, radius_b):
    """Rounded cone from a to b."""
    t, axial = along(p, a, b)
    t = np.clip(t, 0, 1)
    return axial_distance(p, a, b, t) - (radius_a + (radius_b - radius_a) * t)


def along(p, a, b):
    """Parameter of each point along the segment a-b (0 at a, 1 at b) and its length."""
    a, b = np.asarray(a, F32), np.asarray(b, F32)
    length = float(np.linalg.norm(b - a))
    return ((p - a) @ (b - a)) / F32(length * length), length


def axial_distance(p, a, b, t):
    a, b = np.asarray(a, F32), np.asarray(b, F32)
    q = p - a - t[:, None] * (b - a)
    return np.sqrt((q * q).sum(1))


def interp(x, knots, values):
    """Smooth (cubic Hermite, monotone-ish) interpolation through the knots."""
    knots, values = np.asarray(knots, float), np.asarray(values, float)
    slope = np.gradient(values, knots)
    x = np.clip(x, knots[0], knots[-1])
    i = np.clip(np.searchsorted(knots, x) - 1, 0, len(knots) - 2)
    h = knots[i + 1] - knots[i]
    t = (x - knots[i]) / h
    v0, v1, m0, m1 = values[i], values[i + 1], slope[i] * h, slope[i + 1] * h
    return (v0 + t * (m0 + t * (3 * (v1 - v0) - 2 * m0 - m1 + t * (2 * (v0 - v1) + m0 + m1)))).astype(F32)


def loft(p, table, power=2.3):
    """Stack of super-ellipse sections. `table` rows: y, half width, front z, back z."""
    table = np.asarray(table, float)
    y = p[:, 1]
    half_width = interp(y, table[:, 0], table[:, 1])
    front = interp(y, table[:, 0], table[:, 2])
    back = interp(y, table[:, 0], table[:, 3])
    middle, depth = (front + back) / 2, (front - back) / 2
    x, z = np.abs(p[:, 0]), np.abs(p[:, 2] - middle)
    r = ((x / half_width) ** power + (z / depth) ** power) ** (1 / power) + 1e-5
    radial = np.sqrt(x * x + z * z)
    section = np.where(r > 0.05, radial * (1 - 1 / r), -np.minimum(half_width, depth))
    over = np.maximum(table[0, 0] - y, y - table[-1, 0])
    return np.maximum(section, over).astype(F32)


def in_box(p, low, high, field, far=3.0):
    """Evaluate `field` only inside a box; elsewhere the distance to the box plus `far`."""
    low, high = np.asarray(low, F32), np.asarray(high, F32)
    gap = np.maximum(np.maximum(low - p, p - high), 0)
    result = np.sqrt((gap * gap).sum(1)) + F32(far)
    inside = np.flatnonzero((gap <= 0).all(1))
    if len(inside):
        result[inside] = field(p[inside])
    return result.astype(F32)
