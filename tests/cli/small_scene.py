"""A small person and an environment, written as files."""
import struct
import zlib


def png(path, size_px, colour_of):
    rows = b"".join(b"\0" + bytes(v for x in range(size_px) for v in colour_of(x, y)) for y in range(size_px))
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    header = struct.pack(">IIBBBBB", size_px, size_px, 8, 2, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def write_scan(folder):
    """A body of 170 cm: a box with one UV chart a side, skin above fabric."""
    low, high = (-20, 0, -12), (20, 170, 12)
    corners = [(x, y, z) for z in (low[2], high[2]) for y in (low[1], high[1]) for x in (low[0], high[0])]
    sides = [(4, 5, 7, 6), (1, 0, 2, 3), (5, 1, 3, 7), (0, 4, 6, 2), (6, 7, 3, 2), (0, 1, 5, 4)]
    lines = ["mtllib scan.mtl"] + ["v %g %g %g" % c for c in corners]
    for i in range(6):
        u, v = (i % 3) / 3, (i // 3) / 2
        lines += ["vt %g %g" % (u + 0.32 * a, v + 0.48 * b) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
    for i, side in enumerate(sides):
        lines.append("usemtl skin" if i < 4 else "usemtl shirt")
        lines.append("f " + " ".join("%d/%d" % (c + 1, 4 * i + k + 1) for k, c in enumerate(side)))
    (folder / "scan.obj").write_text("\n".join(lines) + "\n")
    (folder / "scan.mtl").write_text("newmtl skin\nmap_Kd colour.png\nnewmtl shirt\nmap_Kd colour.png\n")
    png(folder / "colour.png", 32, lambda x, y: (8 * x, 8 * y, 128))
    return folder / "scan.obj"


def write_hdr(path, width=16, height=8, value=(128, 128, 128, 129)):
    """A constant Radiance picture: the one HDR format that is plain bytes."""
    header = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n" % (height, width)
    path.write_bytes(header + bytes(value) * (width * height))
    return path
