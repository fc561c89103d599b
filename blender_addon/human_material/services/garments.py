# SPDX-License-Identifier: GPL-3.0-or-later
"""Garments of a person in a picture: connected pixels of one class and of one colour. No bpy.

A class's pixels are grouped by colour (CIE L*a*b*, lightness counting half: folds are no border), groups of nearly one
colour are joined, and each connected part of a group is a garment. Small parts belong to the garment around them.
"""
from collections import Counter

from . import decode

COLORS = 4          # looked for in one class
APART = 14.0        # in L/2, a, b: below that two colours are one
LEAST_SHARE = 0.01  # of the class's pixels: less is part of what is around it
ROUNDS = 8


def lab_of(r, g, b):
    """(L*/2, a*, b*) of linear Rec. 709, D65."""
    x = (0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.9505
    y = 0.2126 * r + 0.7152 * g + 0.0722 * b
    z = (0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.089
    fx, fy, fz = (t ** (1 / 3) if t > 0.008856 else 7.787 * t + 16 / 116 for t in (max(x, 0), max(y, 0), max(z, 0)))
    return 58 * fy - 8, 500 * (fx - fy), 200 * (fy - fz)


def _distance2(a, b):
    return (a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2


def _nearest(color, means):
    return min(range(len(means)), key=lambda k: _distance2(color, means[k]))


def colors_of(samples):
    """Means of the distinct colours: k-means from the farthest points, those that are near to each other joined."""
    means = [tuple(sum(s[c] for s in samples) / len(samples) for c in range(3))]
    while len(means) < COLORS:
        far = max(samples, key=lambda s: min(_distance2(s, m) for m in means))
        if min(_distance2(far, m) for m in means) < APART ** 2:
            break
        means.append(far)
    for _ in range(ROUNDS):
        parts = [[] for _ in means]
        for sample in samples:
            parts[_nearest(sample, means)].append(sample)
        means = [tuple(sum(s[c] for s in part) / len(part) for c in range(3)) for part in parts if part]
    joined = []
    for mean in means:
        if all(_distance2(mean, other) >= APART ** 2 for other in joined):
            joined.append(mean)
    return joined


def find(diffuse, shares, class_count, width, height):
    """(bytearray of each pixel's garment, 0 is none; [(number, class, pixels)] with the largest of a class first).
    diffuse: 3 values a pixel; shares: class_count a pixel. At most 255 garments."""
    numbers, found = bytearray(width * height), []
    for c in range(class_count):
        pixels = [p for p in range(width * height) if shares[class_count * p + c] > 0.5]
        if not pixels:
            continue
        labels = _color_labels(diffuse, pixels)
        pieces = _pieces(labels, width)
        large = [piece for piece in pieces if len(piece) >= max(8, LEAST_SHARE * len(pixels))] or pieces[:1]
        for piece in large[:255 - len(found)]:
            found.append((len(found) + 1, c, piece))
            for p in piece:
                numbers[p] = len(found)
        _adopt(numbers, pixels, width, {number for number, of, _ in found if of == c})
    sizes = Counter(numbers)
    return numbers, [(number, c, sizes[number]) for number, c, _ in found]


def _color_labels(diffuse, pixels):
    """Pixel -> which colour; each takes the one of most pixels around it, so that prints and folds are no garments."""
    lab = {p: lab_of(*diffuse[3 * p:3 * p + 3]) for p in pixels}
    step = max(1, len(pixels) // 2000)
    means = colors_of([lab[p] for p in pixels[::step]])
    return {p: _nearest(color, means) for p, color in lab.items()} if len(means) > 1 else dict.fromkeys(pixels, 0)


def _neighbours(p, width):
    x = p % width
    return (p - width, p + width, p - 1 if x else -1, p + 1 if x + 1 < width else -1)


def _pieces(labels, width):
    """Connected pixels of one label, the largest first."""
    left, pieces = set(labels), []
    while left:
        first = left.pop()
        piece = [first]
        for p in piece:
            for q in _neighbours(p, width):
                if q in left and labels[q] == labels[first]:
                    left.remove(q)
                    piece.append(q)
        pieces.append(piece)
    return sorted(pieces, key=lambda piece: (-len(piece), min(piece)))


def _adopt(numbers, pixels, width, own):
    """Pixels of the class without a garment take that of their neighbours, ring by ring; those beside none stay."""
    left = {p for p in pixels if numbers[p] == 0}
    while left:
        ring = {}
        for p in left:
            around = Counter(numbers[q] for q in _neighbours(p, width) if 0 <= q < len(numbers) and numbers[q] in own)
            if around:
                ring[p] = max(around, key=lambda n: (around[n], -n))
        if not ring:
            return
        for p, number in ring.items():
            numbers[p] = number
        left.difference_update(ring)


def grown(numbers, width, steps=2):
    """The same a few pixels farther: soft borders hold a share of the class there, other pixels none."""
    result = bytearray(numbers)
    for _ in range(steps):
        ring = {}
        for p in range(len(result)):
            if result[p]:
                continue
            for q in _neighbours(p, width):
                if 0 <= q < len(result) and result[q]:
                    ring[p] = result[q]
                    break
        for p, number in ring.items():
            result[p] = number
    return result


def mean_luminance(diffuse, numbers, number):
    pixels = [p for p in range(len(numbers)) if numbers[p] == number]
    return sum(decode.luminance(*diffuse[3 * p:3 * p + 3]) for p in pixels) / max(len(pixels), 1)
