"""With NumPy the add-on computes what it computes without it."""
import math
import random
import unittest
from array import array

import support  # noqa: F401

from human_material.services import classes, decode, grid, maps_json, vector

W, H = 37, 29
CAMERA = maps_json.Camera("perspective", distance_cm=400, half_width=0.2)


def rasters():
    """A made-up person with noise, pits, a depth step and four classes."""
    rng = random.Random(5)
    table = [(e["specular"], e["roughness"], e["sss"]) for e in classes.TABLE]
    made = {"mask": array("f"), "normal": array("f"), "diffuse": array("f"), "f0": array("f"), "roughness": array("f"),
            "sss": array("f"), "depth": array("f")}
    for p in range(W * H):
        x, y = p % W, p // W
        inside = math.hypot((x - 18) / 16, (y - 14) / 13) < 1
        n = (0.05 * (x - 18) + rng.gauss(0, 0.02), 0.06 * (y - 14), 0.6)
        spec, rough, sss = table[(x > 18) + 2 * (y > 14)]
        made["mask"].append(float(inside))
        made["normal"].extend(n)
        made["diffuse"].extend(rng.random() for _ in range(3))
        made["f0"].append(spec + rng.gauss(0, 0.01))
        made["roughness"].append(rough + rng.gauss(0, 0.01))
        made["sss"].append(max(0.0, sss))
        made["depth"].append(0.2 * x - 0.1 * y + 20 * (x > 25) - 4 * (rng.random() < 0.03))
    return made


def computed():
    """Everything that the add-on computes of them before Blender comes in."""
    m = rasters()
    pixels = decode.covered_pixels(m["mask"])
    decode.check_finite(m["depth"], 1, pixels, W, H, "m")
    decode.clamp_unit(m["diffuse"], 3, pixels, W, H, "m")
    decode.decode_normals(m["normal"], pixels, "signed", "n")
    decode.decode_each(m["diffuse"], 3, pixels, decode.srgb_to_linear)
    decode.decode_each(m["f0"], 1, pixels, decode.F0_OF["srgb_f0"])
    known = bytearray(value > 0 for value in m["mask"])
    decode.check_green_up(m["normal"], m["depth"], pixels, known, W, H, "n")
    shares = classes.shares_of_materials(m["f0"], m["roughness"], m["sss"], pixels, W, H)
    decode.mend_pits(m["depth"], known, W, H)
    grown = bytearray(known)
    decode.grow(m["normal"], 3, grown, W, H, 2)
    decode.grow_depth(m["depth"], m["normal"], known, W, H, 2, 0.5)
    decode.turn_away(m["normal"], m["mask"], known)
    relief = grid.build(m["depth"], known, W, H, CAMERA)
    return m, shares, known, grown, relief


@unittest.skipUnless(vector.np, "there is no NumPy")
class Vector(unittest.TestCase):
    def test_the_same_with_and_without_numpy(self):
        fast = computed()
        found, vector.np = vector.np, None
        try:
            plain = computed()
        finally:
            vector.np = found
        mask = array("f", [0.0, 1e-9, 1.0, -0.5])
        self.assertEqual(decode.covered(mask), bytearray(value > 0 for value in mask))
        for name, values in plain[0].items():
            worst = max(abs(a - b) for a, b in zip(values, fast[0][name]))
            self.assertLess(worst, 1e-5, name)
        self.assertLess(max(abs(a - b) for a, b in zip(plain[1], fast[1])), 1e-5)
        self.assertEqual(plain[2:4], fast[2:4])
        self.assertEqual(len(plain[4].faces), len(fast[4].faces))
        self.assertEqual(sorted(tuple(f) for f in plain[4].faces)[:50], sorted(tuple(f) for f in fast[4].faces)[:50])
        for a, b in zip(plain[4].vertices, fast[4].vertices):
            self.assertLess(max(abs(u - v) for u, v in zip(a, b)), 1e-6)
