"""PNG and EXR files written byte by byte, so that tests can make any file, broken ones too. Rows from the top."""
import struct
import zlib


def png(path, width, height, values, channels=1, bits=16, alpha=False):
    """values: codes (0 to 255 or 65535), channels (+ 1 if alpha) a pixel."""
    stored = channels + alpha
    code = {(1, False): 0, (3, False): 2, (1, True): 4, (3, True): 6}[channels, alpha]
    shape = ">%d%s" % (width * stored, "H" if bits == 16 else "B")
    rows = b"".join(b"\0" + struct.pack(shape, *values[y * width * stored:(y + 1) * width * stored])
                    for y in range(height))
    data = b"\x89PNG\r\n\x1a\n"
    for name, body in ((b"IHDR", struct.pack(">IIBBBBB", width, height, bits, code, 0, 0, 0)),
                       (b"IDAT", zlib.compress(rows, 1)), (b"IEND", b"")):
        data += struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))
    with open(path, "wb") as file:
        file.write(data)


def exr(path, width, height, values, channels="RGB", flags=0, window=None):
    """An uncompressed float EXR; values in the order of `channels`."""
    names = sorted(channels)
    listed = b"".join(n.encode() + b"\0" + struct.pack("<iB3xii", 2, 0, 1, 1) for n in names) + b"\0"
    box = struct.pack("<4i", 0, 0, width - 1, height - 1)
    data = b"\x76\x2f\x31\x01" + struct.pack("<I", 2 | flags)
    for name, kind, body in (("channels", "chlist", listed), ("compression", "compression", b"\0"),
                             ("dataWindow", "box2i", window or box), ("displayWindow", "box2i", box),
                             ("lineOrder", "lineOrder", b"\0"), ("pixelAspectRatio", "float", struct.pack("<f", 1)),
                             ("screenWindowCenter", "v2f", struct.pack("<ff", 0, 0)),
                             ("screenWindowWidth", "float", struct.pack("<f", 1))):
        data += name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(body)) + body
    data += b"\0"
    count, line = len(channels), 4 * width * len(channels)
    first = len(data) + 8 * height
    data += b"".join(struct.pack("<Q", first + y * (8 + line)) for y in range(height))
    for y in range(height):
        row = values[y * width * count:(y + 1) * width * count]
        data += struct.pack("<ii", y, line)
        for name in names:
            data += struct.pack("<%df" % width, *row[channels.index(name)::count])
    with open(path, "wb") as file:
        file.write(data)
