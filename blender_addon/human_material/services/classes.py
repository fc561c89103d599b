# SPDX-License-Identifier: GPL-3.0-or-later
"""The material classes of data/materials.json, and soft masks of them decoded from the material maps. No bpy.

The maps are averages of the table's materials over a pixel, so a pixel on a border holds a mixture. Three of the
materials lie almost on one line (a mixture of fabric and leather looks like hair), so a pixel alone does not tell: a
pixel is first given the nearest class, then that of most pixels around it, and last, on borders, split between the
two classes nearby whose mixture fits it best. An estimate may be half fabric, half leather over a whole sleeve, which
looks like hair too: so hair is only what is connected to hair on the head, or in the upper third of the person.
"""
import json
import os
from collections import Counter

from . import decode, vector

_FILE = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "data", "materials.json")
with open(_FILE, encoding="utf-8") as _stream:
    _DATA = json.load(_stream)
TABLE = _DATA["classes"]
LEAST_SSS = _DATA["least_sss"]   # a map below this says that light does not scatter
NAMES = tuple(entry["name"] for entry in TABLE)

SSS_SCALE = 5.0         # subsurface counts five times: its range is a tenth of the others'
VOTE_RADIUS_PX = 2      # 5 x 5 pixels vote
BORDER_RADIUS_PX = 2    # mixtures are looked for this near to another class
HEAD_SHARE = 1 / 8      # of the person's height in the picture: hair on the head reaches into it
UPPER_SHARE = 1 / 3
HAIR = NAMES.index("hair")
NOTHING = 255


def feature(f0, roughness, sss):
    """The point of the space in which materials are compared. Specular counts as S, where the table is even."""
    return decode.linear_to_srgb(f0), roughness, SSS_SCALE * sss


FEATURES = tuple(feature(decode.srgb_to_linear(e["specular"]), e["roughness"], e["sss"]) for e in TABLE)


def shares_of_map(values, pixels):
    """From the map `classes` (a channel a class but the first) to a share of each class; they sum to 1."""
    others, every = len(NAMES) - 1, len(NAMES)
    shares = decode.zeros(len(values) // others * every)
    if vector.np:
        stated = vector.view(values, others)[pixels].astype(float)
        total = stated.sum(1, keepdims=True)
        vector.view(shares, every)[pixels] = vector.np.concatenate(
            [vector.np.maximum(0.0, 1 - total), stated / vector.np.maximum(total, 1.0)], 1)
        return shares
    for p in pixels:
        pixel = values[others * p:others * p + others]
        total = max(sum(pixel), 1.0)
        shares[every * p:every * p + every] = decode.array("f", (
            max(0.0, 1 - sum(pixel)), *(share / total for share in pixel)))
    return shares


def shares_of_materials(f0, roughness, sss, pixels, width, height):
    """Soft masks of the classes, decoded from the material maps: a share of each a pixel; they sum to 1."""
    steps = _fast_steps if vector.np else _steps
    points, voted, mixed = steps(f0, roughness, sss, pixels, width, height)
    every = len(NAMES)
    shares = decode.zeros(every * width * height)
    for p in pixels if mixed is None else mixed:
        nearby = _classes_around(voted, p, width, height, BORDER_RADIUS_PX)
        if len(nearby) == 1:
            shares[every * p + voted[p]] = 1.0
        else:
            a, b, t = best_mixture(points(p), sorted(nearby))
            shares[every * p + a] = 1 - t
            shares[every * p + b] += t
    if mixed is not None:
        alone = vector.np.setdiff1d(pixels, mixed, assume_unique=True)
        vector.view(shares, every)[alone, vector.view(voted)[alone]] = 1.0
    return shares


def _steps(f0, roughness, sss, pixels, width, height):
    """(point of a pixel, voted classes, None: every pixel may be a mixture)."""
    points = {p: feature(f0[p], roughness[p], sss[p]) for p in pixels}
    nearest = bytearray([NOTHING]) * (width * height)
    known = {}
    for p, point in points.items():
        if point not in known:
            known[point] = nearest_class(point)
        nearest[p] = known[point]
    voted = vote(nearest, pixels, width, height)
    for p in stray_hair(voted, pixels, width, height):
        voted[p] = nearest_class(points[p], without=HAIR)
    return points.__getitem__, voted, None


def _fast_steps(f0, roughness, sss, pixels, width, height):
    """The same; the third are the pixels near to another class."""
    np = vector.np
    pixels = np.asarray(pixels)
    all_points = np.stack([vector.linear_to_srgb(vector.view(f0)[pixels].astype(float)),
                           vector.view(roughness)[pixels], SSS_SCALE * vector.view(sss)[pixels]], 1)
    at = np.zeros(width * height, np.int64)
    at[pixels] = np.arange(len(pixels))

    def point(p):
        return tuple(all_points[at[p]])
    nearest = vector.nearest_classes(all_points, FEATURES, NOTHING, pixels, width * height)
    voted = vector.vote(nearest, pixels, len(NAMES), width, height, VOTE_RADIUS_PX)
    for p in stray_hair(voted, pixels, width, height):
        voted[p] = nearest_class(point(p), without=HAIR)
    kinds = (vector.windows(voted, len(NAMES), width, height, BORDER_RADIUS_PX) > 0).sum(0).ravel()
    return point, voted, pixels[kinds[pixels] > 1]


def nearest_class(point, without=NOTHING):
    return min((c for c in range(len(FEATURES)) if c != without), key=lambda c: _distance2(point, FEATURES[c]))


def stray_hair(labels, pixels, width, height):
    """Pixels of the pieces of hair that do not reach into the head, or, where none does (a hat, raised arms), into
    the upper third of the person: shoes of an estimate may look like hair on somebody whose hair was not found."""
    if len(pixels) == 0:
        return []
    first, last = int(min(pixels)) // width, int(max(pixels)) // width
    pieces = list(_pieces(labels, HAIR, width, height))
    for share in (HEAD_SHARE, UPPER_SHARE):
        end = first + share * (last + 1 - first)
        stray = [piece for piece in pieces if min(piece) // width >= end]
        if len(stray) < len(pieces):
            break
    return [p for piece in stray for p in piece]


def _pieces(labels, wanted, width, height):
    """Connected pixels of one class, neighbours by edge: a list for each piece."""
    left = {p for p in range(width * height) if labels[p] == wanted}
    while left:
        piece = [left.pop()]
        for p in piece:
            x = p % width
            for q in (p - width, p + width, p - 1 if x else -1, p + 1 if x + 1 < width else -1):
                if q in left:
                    left.remove(q)
                    piece.append(q)
        yield piece


def vote(labels, pixels, width, height):
    """Each pixel takes the class of most pixels in the 5 x 5 around it; on a tie it keeps its own, or the lowest."""
    result = bytearray(labels)
    for p in pixels:
        counts = Counter(_window(labels, p, width, height, VOTE_RADIUS_PX))
        counts.pop(NOTHING, None)
        if len(counts) > 1:
            result[p] = max(counts, key=lambda c: (counts[c], c == labels[p], -c))
    return result


def best_mixture(point, candidates):
    """(a, b, t): point is nearest to (1 - t) a + t b of all pairs of candidate classes."""
    best = None
    for i, a in enumerate(candidates):
        for b in candidates[i + 1:]:
            t = _share_between(point, FEATURES[a], FEATURES[b])
            mixed = tuple(u + t * (v - u) for u, v in zip(FEATURES[a], FEATURES[b]))
            distance = _distance2(point, mixed)
            if best is None or distance < best[0]:
                best = (distance, a, b, t)
    return best[1:]


def _share_between(point, a, b):
    along = [v - u for u, v in zip(a, b)]
    t = sum((x - u) * d for x, u, d in zip(point, a, along)) / sum(d * d for d in along)
    return min(max(t, 0.0), 1.0)


def _distance2(a, b):
    return (a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2


def _window(labels, p, width, height, radius):
    """Labels of the square around p, cut at the frame."""
    x, y = p % width, p // width
    left, right = max(0, x - radius), min(width, x + radius + 1)
    values = b""
    for row in range(max(0, y - radius), min(height, y + radius + 1)):
        values += labels[row * width + left:row * width + right]
    return values


def _classes_around(labels, p, width, height, radius):
    found = set(_window(labels, p, width, height, radius))
    found.discard(NOTHING)
    return found
