# SPDX-License-Identifier: GPL-3.0-or-later
"""PNG of 8 bits and float EXR, written without Blender's colour management. Rasters have row 0 at the bottom. No bpy."""
import struct
import zlib
from array import array


def png_bytes(width, height, codes, channels):
    """codes: a byte for each channel (1, 3 or 4) of each pixel."""
    kind = {1: 0, 3: 2, 4: 6}[channels]
    step = width * channels
    rows = b"".join(b"\0" + bytes(codes[y * step:(y + 1) * step]) for y in range(height - 1, -1, -1))
    data = b"\x89PNG\r\n\x1a\n"
    for name, body in ((b"IHDR", struct.pack(">IIBBBBB", width, height, 8, kind, 0, 0, 0)),
                       (b"IDAT", zlib.compress(rows, 6)), (b"IEND", b"")):
        data += struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))
    return data


def _attribute(name, kind, body):
    return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(body)) + body


def exr_bytes(width, height, values, channels):
    """One part, no compression. channels: the names in the order of the values ("RGB", "Y")."""
    names = sorted(channels)
    listed = b"".join(n.encode() + b"\0" + struct.pack("<iB3xii", 2, 0, 1, 1) for n in names) + b"\0"
    box = struct.pack("<4i", 0, 0, width - 1, height - 1)
    head = struct.pack("<II", 20000630, 2) + b"".join((
        _attribute("channels", "chlist", listed), _attribute("compression", "compression", b"\0"),
        _attribute("dataWindow", "box2i", box), _attribute("displayWindow", "box2i", box),
        _attribute("lineOrder", "lineOrder", b"\0"), _attribute("pixelAspectRatio", "float", struct.pack("<f", 1)),
        _attribute("screenWindowCenter", "v2f", struct.pack("<ff", 0, 0)),
        _attribute("screenWindowWidth", "float", struct.pack("<f", 1)))) + b"\0"
    line, step, first = 4 * width * len(names), width * len(names), len(head) + 8 * height
    table = struct.pack("<%dQ" % height, *(first + y * (8 + line) for y in range(height)))
    lines = []
    for y in range(height):
        row = values[(height - 1 - y) * step:(height - y) * step]
        lines.append(struct.pack("<ii", y, line))
        lines += [array("f", row[channels.index(name)::len(channels)]).tobytes() for name in names]
    return head + table + b"".join(lines)
