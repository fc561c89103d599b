"""humanmaterial torchscript in PyTorch: what the file gives for the picture that `estimate` shows is what `estimate` wrote.

    torchscript_test.py HUMANMATERIAL WEIGHTS_FOLDER

Exits with 77 where Python has no torch.
"""
import json
import os
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

DEBIAN = "/usr/bin/python3"
try:
    import numpy
    import torch
except ImportError as error:
    if sys.executable != DEBIAN and os.path.exists(DEBIAN):     # where python3-torch is
        os.execv(DEBIAN, [DEBIAN, *sys.argv])
    print("skipped: %s; install Debian's python3-torch" % error)
    sys.exit(77)

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "cli"))
from small_scene import png  # noqa: E402

HUMANMATERIAL, WEIGHTS = sys.argv[1:3]
SIZE = 128      # that the weights were trained at
TOLERANCE = 5e-4    # group norm is another kernel, and pictures have 65,536 levels


def write_photo(folder):
    """A striped egg: no symmetry, no plain colour."""
    def is_inside(x, y):
        return ((x - 95) / 50) ** 2 + ((y - 100) / 85) ** 2 < 1
    png(folder / "photo.png", 200, lambda x, y: (x, 60 + 9 * (y % 16), (3 * x + y) % 256))
    png(folder / "mask.png", 200, lambda x, y: (255 * is_inside(x, y),) * 3)


def read_png(path):
    """(height, width, channels) in [0, 1] of a 16-bit PNG without interlace."""
    data, at, packed = path.read_bytes(), 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + length]
        if kind == b"IHDR":
            width, height, bits, colour = struct.unpack(">IIBB", body[:10])
        if kind == b"IDAT":
            packed += body
        at += 12 + length
    assert bits == 16, bits
    pixel = 2 * {0: 1, 2: 3, 4: 2, 6: 4}[colour]
    raw, rows = zlib.decompress(packed), []
    previous = numpy.zeros(width * pixel, numpy.int64)
    for y in range(height):
        begin = y * (width * pixel + 1)
        kind, row = raw[begin], numpy.frombuffer(raw, numpy.uint8, width * pixel, begin + 1).astype(numpy.int64)
        for x in range(width * pixel):
            left = row[x - pixel] if x >= pixel else 0
            corner = previous[x - pixel] if x >= pixel else 0
            up = previous[x]
            if kind == 4:
                nearest = min((abs(up - corner), 0, left), (abs(left - corner), 1, up), (abs(left + up - 2 * corner), 2, corner))
                row[x] += nearest[2]
            else:
                row[x] += (0, left, up, (left + up) // 2)[kind]
            row[x] &= 255
        rows.append(previous := row)
    bytes_ = numpy.stack(rows).astype(numpy.uint8).tobytes()
    return numpy.frombuffer(bytes_, ">u2").reshape(height, width, -1).astype(numpy.float32) / 65535


def tensor_of(path):
    return torch.from_numpy(read_png(path)).permute(2, 0, 1).unsqueeze(0)


def srgb_of(linear):
    return torch.where(linear <= 0.0031308, linear * 12.92, 1.055 * linear.clamp_min(0.0031308) ** (1 / 2.4) - 0.055)


class Estimate(unittest.TestCase):
    def test_is_the_programs(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            write_photo(folder)
            weights = [os.path.join(WEIGHTS, name) for name in sorted(os.listdir(WEIGHTS)) if name.endswith(".safetensors")]
            script, maps = folder / "estimator.pt", folder / "maps"
            subprocess.run([HUMANMATERIAL, "torchscript", "--weights", *weights, "-o", script], check=True)
            subprocess.run([HUMANMATERIAL, "estimate", folder / "photo.png", "--mask", folder / "mask.png", "--weights", *weights, "--size", str(SIZE),
                            "-o", maps], check=True)
            extra = {"humanmaterial.json": ""}
            network = torch.jit.load(str(script), _extra_files=extra)
            self.assertEqual(json.loads(extra["humanmaterial.json"])["size_px"], SIZE)
            picture, mask = (tensor_of(maps / (name + ".png")) for name in ("input", "mask"))
            with torch.no_grad():
                # A batch of two: the second is the mirror image, whose maps are the mirror image of the maps.
                found = network(torch.cat([picture, picture.flip(3)]), torch.cat([mask, mask.flip(3)]))
            for name, stored in (("normal", found["normal"] / 2 + 0.5), ("diffuse", srgb_of(found["diffuse"])),
                                 ("roughness", found["roughness"]), ("specular", found["specular"]),
                                 ("displacement", found["displacement"] / 2 + 0.5)):
                written = tensor_of(maps / (name + ".png"))
                inside = (mask > 0).expand_as(written)
                self.assertGreater(written[inside].std(), 1e-3, name)
                self.assertLess((stored[:1] - written)[inside].abs().max(), TOLERANCE, name)
                mirrored = stored[1:].flip(3)
                if name == "normal":
                    mirrored[:, 0] = 1 - mirrored[:, 0]
                self.assertLess((mirrored - written)[inside].abs().max(), TOLERANCE, name)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
