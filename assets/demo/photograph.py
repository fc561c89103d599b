#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A picture like a photograph, of somebody who was rendered: before a wall, on a floor, with the camera's noise, upright.

usage: photograph.py PREVIEW.png OUT.png
PREVIEW: the person, sRGB with straight alpha, as render writes it. Python's standard library and numpy.
"""
import struct
import sys
import zlib

import numpy as np

WALL, FLOOR, SEED = (0.62, 0.60, 0.55), (0.34, 0.27, 0.21), 1    # sRGB


def read_png(name):
    """Rows of RGBA pixels in [0, 1]; 8 bits, not interlaced, as our previews are."""
    with open(name, "rb") as file:
        data = file.read()
    position, packed = 8, b""
    while position < len(data):
        size, kind = struct.unpack(">I4s", data[position:position + 8])
        body = data[position + 8:position + 8 + size]
        if kind == b"IHDR":
            width, height, depth, colour = struct.unpack(">IIBB", body[:10])
            if (depth, colour, body[12]) != (8, 6, 0):
                sys.exit(f"{name}: is no plain 8-bit PNG with alpha; give a picture that render wrote")
        packed += body if kind == b"IDAT" else b""
        position += size + 12
    lines = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, 1 + 4 * width)
    rows = np.zeros((height + 1, width + 1, 4), int)             # with a line above and a pixel before
    for y, line in enumerate(lines, 1):
        filtered, kind = line[1:].reshape(width, 4).astype(int), line[0]
        if kind in (0, 2):
            rows[y, 1:] = (filtered + (rows[y - 1, 1:] if kind else 0)) & 255
            continue
        for x in range(1, width + 1):
            left, up, corner = rows[y, x - 1], rows[y - 1, x], rows[y - 1, x - 1]
            guess = left + up - corner
            a, b, c = abs(guess - left), abs(guess - up), abs(guess - corner)
            paeth = np.where((a <= b) & (a <= c), left, np.where(b <= c, up, corner))
            rows[y, x] = (filtered[x - 1] + {1: left, 3: (left + up) // 2, 4: paeth}[kind]) & 255
    return rows[1:, 1:] / 255


def write_png(name, rows):
    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    codes = np.round(np.clip(rows, 0, 1) * 255).astype(np.uint8)
    height, width = codes.shape[:2]
    lines = b"".join(b"\0" + line.tobytes() for line in codes)
    with open(name, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)) +
                   chunk(b"IDAT", zlib.compress(lines, 6)) + chunk(b"IEND", b""))


def room(height, width, soles):
    """A wall that darkens outwards a little and a floor from a little above the soles on."""
    y, x = np.mgrid[0:height, 0:width]
    vignette = 1 - 0.04 * (((x / width - 0.5) ** 2 + (y / height - 0.4) ** 2) / 0.5)[..., None]
    edge = np.clip((y - soles + 0.06 * height) / (0.01 * height), 0, 1)[..., None]
    return (np.array(WALL) * (1 - edge) + np.array(FLOOR) * edge) * vignette


def linear(x):
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)


def encoded(x):
    return np.where(x <= 0.0031308, x * 12.92, 1.055 * np.maximum(x, 0.0031308) ** (1 / 2.4) - 0.055)


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    person = read_png(sys.argv[1])
    colours, mask = linear(person[..., :3]), person[..., 3:]
    side = mask.shape[0]
    height, width = side * 5 // 4, side
    covered = np.flatnonzero(mask[..., 0].max(axis=1) > 0.5)
    top, soles = side // 8, side // 8 + (covered[-1] if covered.size else side)
    picture = linear(room(height, width, soles))
    y, x = np.mgrid[0:height, 0:width]
    centre = np.average(np.arange(width), weights=mask[..., 0].sum(axis=0) + 1e-9)
    shadow = np.exp(-((x - centre) / (0.13 * side)) ** 2 - ((y - soles) / (0.02 * side)) ** 2)
    picture *= 1 - 0.6 * shadow[..., None]
    picture[top:top + side] = mask * colours + (1 - mask) * picture[top:top + side]
    noise = np.random.default_rng(SEED).normal(0, 0.012, (height, width, 1))
    write_png(sys.argv[2], encoded(picture) + noise)


if __name__ == "__main__":
    main()
