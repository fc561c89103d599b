# SPDX-License-Identifier: Apache-2.0
"""From the rasterised atlas to the finished scan-like texture."""
import numpy as np

from . import clothes
from .fields import F32
from .paint import PAINTERS

DILATE_PX = 12


class Samples:
    """What a painter needs to know of the texels of one part."""

    def __init__(self, p, normal, part, ao, ridge):
        self.p, self.normal, self.part, self.ao, self.ridge = p, normal, part, ao, ridge

    def take(self, rows):
        return Samples(self.p[rows], self.normal[rows], self.part[rows], self.ao[rows], self.ridge[rows])


class Grid:
    """Trilinear look-up in the distance grid that the mesh came from."""

    def __init__(self, values, xs, ys, zs):
        self.values, self.axes = values, (xs, ys, zs)

    def __call__(self, p):
        lower, share = [], []
        for axis, coords in enumerate(self.axes):
            i = np.clip(np.searchsorted(coords, p[:, axis]) - 1, 0, len(coords) - 2)
            lower.append(i)
            share.append(np.clip((p[:, axis] - coords[i]) / (coords[i + 1] - coords[i]), 0, 1).astype(F32))
        total = np.zeros(len(p), F32)
        for corner in range(8):
            bits = [(corner >> k) & 1 for k in range(3)]
            weight = np.ones(len(p), F32)
            for k in range(3):
                weight = weight * (share[k] if bits[k] else 1 - share[k])
            total += weight * self.values[lower[0] + bits[0], lower[1] + bits[1], lower[2] + bits[2]]
        return total


def vertex_normals(vertices, faces):
    p = vertices[faces].astype(np.float64)
    cross = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    normal = np.stack([np.bincount(faces.ravel(), np.repeat(cross[:, axis], 3), len(vertices)) for axis in range(3)], 1)
    return (normal / (np.linalg.norm(normal, axis=1, keepdims=True) + 1e-12)).astype(F32)


def surface_samples(vertices, faces, uv_px, image, face_class, grid):
    """Position, normal, part and two shading measures at every covered texel."""
    row, column = np.nonzero(image >= 0)
    face = image[row, column]
    a, b, c = (uv_px[face, k] for k in range(3))
    q = np.stack([column + 0.5, row + 0.5], 1)
    area = _cross(b - a, c - a)
    w1, w2 = _cross(q - a, c - a) / area, _cross(b - a, q - a) / area
    weights = np.stack([1 - w1 - w2, w1, w2], 1).astype(F32)
    p = np.einsum("nk,nkd->nd", weights, vertices.astype(F32)[faces[face]])
    normal = np.einsum("nk,nkd->nd", weights, vertex_normals(vertices, faces)[faces[face]])
    part = np.empty(len(p), np.int64)
    for start in range(0, len(p), 400000):
        rows = slice(start, start + 400000)
        d = clothes.distances(p[rows])
        d[clothes.CLASS_OF_PART[:, None] != face_class[face[rows]][None]] = 1e9
        part[rows] = d.argmin(0)
    ao = sum(np.clip(grid(p + normal * reach) / reach, 0, 1) for reach in (0.6, 1.4, 3.0)) / 3
    ridge = np.clip(1 + grid(p - normal * 1.2) / 1.2, 0, 1)
    return row, column, Samples(p, normal, part, ao.astype(F32), ridge.astype(F32))


def _cross(a, b):
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def paint_atlas(size_px, row, column, samples, log):
    """Display-referred colours 0..1; the first row is the bottom of the picture."""
    colour = np.zeros((len(row), 3), F32)
    for number, (name, *_) in enumerate(clothes.PARTS):
        for rows in np.array_split(np.flatnonzero(samples.part == number), 4):
            if len(rows):
                colour[rows] = PAINTERS[number](samples.take(rows))
        log("painted " + name)
    picture = np.zeros((size_px, size_px, 3), F32)
    known = np.zeros((size_px, size_px), bool)
    picture[row, column], known[row, column] = colour, True
    picture = dilate(soften(picture, known), known)
    return photographic(picture)


def soften(picture, known):
    """The blur of a camera a good metre away: a light 3 x 3 kernel inside charts."""
    weight = known.astype(F32)
    total, norm = picture * 4 * weight[..., None], weight * 4
    for axis in (0, 1):
        for shift in (1, -1):
            total = total + np.roll(picture * weight[..., None], shift, axis)
            norm = norm + np.roll(weight, shift, axis)
    return np.where(known[..., None], total / np.maximum(norm, 1)[..., None], picture)


def dilate(picture, known):
    """Carry colours past the chart borders, so that filtering never meets the background."""
    for _ in range(DILATE_PX):
        total, count = np.zeros_like(picture), np.zeros(known.shape, F32)
        for dy in (-1, 0, 1):
            for dx in (-1, 0, 1):
                seen = np.roll(known, (dy, dx), (0, 1))
                total += np.roll(picture, (dy, dx), (0, 1)) * seen[..., None]
                count += seen
        fresh = ~known & (count > 0)
        picture[fresh] = total[fresh] / count[fresh][:, None]
        known = known | fresh
    picture[~known] = picture[known].mean(0)
    return picture


def photographic(picture):
    """Sensor noise, stronger in the darks, and a trace of colour noise."""
    rng = np.random.RandomState(77)
    grey = rng.standard_normal(picture.shape[:2]).astype(F32)
    tint = rng.standard_normal(picture.shape).astype(F32)
    level = 0.010 + 0.006 * (1 - picture.mean(2))
    return np.clip(picture + (grey * level)[..., None] + tint * 0.005, 0, 1)
