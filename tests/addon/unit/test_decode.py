"""Encodings and ranges."""
import math
import unittest
from array import array

import support  # noqa: F401

from human_material.services import decode, maps_json
from human_material.services.errors import InputError


class Decode(unittest.TestCase):
    def test_srgb_round_trip(self):
        for i in range(256):
            self.assertAlmostEqual(decode.linear_to_srgb(decode.srgb_to_linear(i / 255)), i / 255, places=9)

    def test_specular_encodings_agree_on_skin(self):
        """Skin: code 47 of 255 is F0 = 0.028 (Real-Time Rendering, 4th ed., table 9.1), Specular 0.35."""
        self.assertAlmostEqual(decode.F0_OF["srgb_f0"](47 / 255), 0.028, delta=0.0005)
        self.assertAlmostEqual(decode.F0_OF["disney08"](0.35), 0.028)
        self.assertEqual(decode.F0_OF["linear_f0"](0.028), 0.028)

    def test_isolated_pits_are_filled_and_nothing_else(self):
        size = 9
        known = bytearray([1]) * (size * size)
        slope = array("f", [0.4 * (p % size) + 0.15 * (p // size) for p in range(size * size)])
        for deep, is_pit in (((40,), True), ((40, 41, 49, 50), True), (tuple(range(4, 81, 9)), False),
                             (tuple(range(36, 45)), False), ((39, 40, 41, 48, 49, 50, 30, 31, 32), False),
                             (tuple(range(0, 81, 10)), False), ((0,), False)):
            depth = array("f", slope)
            for p in deep:
                depth[p] -= 4
            before = array("f", depth)
            decode.mend_pits(depth, known, size, size)
            for p in range(size * size):
                if is_pit and p in deep:
                    self.assertAlmostEqual(depth[p], slope[p], delta=1.2)   # to the lowest neighbour
                else:
                    self.assertEqual(depth[p], before[p], (deep, p))

    def test_pits_beside_the_outline_stay(self):
        depth, known = array("f", [0, 0, 0, 0, -4, 0, 0, 0, 0]), bytearray([1, 1, 1, 1, 1, 0, 1, 1, 1])
        decode.mend_pits(depth, known, 3, 3)
        self.assertEqual(depth[4], -4)

    def test_normals(self):
        for encoding, values in (("offset", (0.5, 0.5, 1.0)), ("signed", (0.0, 0.0, 1.0))):
            raster = array("f", values)
            decode.decode_normals(raster, [0], encoding, "n")
            self.assertEqual(list(raster), [0, 0, 1])
        for encoding, values, words in (("signed", (0.5, 0.5, 1.0), "length"), ("offset", (0.0, 0.0, 1.0), "length"),
                                        ("signed", (0.0, 0.0, -1.0), "away")):
            with self.assertRaises(InputError) as caught:
                decode.decode_normals(array("f", values), [0], encoding, "n")
            self.assertIn(words, str(caught.exception))

    def test_displacement(self):
        camera = maps_json.Camera("perspective", distance_cm=400, half_width=0.2)
        raster = array("f", (0.75, 0.5))
        decode.decode_displacement(raster, [0, 1], "offset", 100, camera, 2, 1, "d")
        self.assertEqual(list(raster), [50, 0])
        with self.assertRaises(InputError) as caught:
            decode.decode_displacement(array("f", (0, 400)), [0, 1], "signed_cm", 0, camera, 2, 1, "d")
        self.assertIn("pixel (1, 0)", str(caught.exception))

    def test_not_finite_is_named_from_the_top_left(self):
        raster = array("f", (0, 0, 0, 0, math.nan, 0))   # 3 x 2, lower row first
        with self.assertRaises(InputError) as caught:
            decode.check_finite(raster, 1, range(6), 3, 2, "m")
        self.assertIn("pixel (1, 0)", str(caught.exception))
        decode.check_finite(raster, 1, [0, 1], 3, 2, "m")   # elsewhere it does not matter

    def test_clamp(self):
        raster = array("f", (-0.005, 0.5, 1.005))
        decode.clamp_unit(raster, 1, range(3), 3, 1, "m")
        self.assertEqual(list(raster), [0, 0.5, 1])
        self.assertRaises(InputError, decode.clamp_unit, array("f", (1.5,)), 1, [0], 1, 1, "m")

    def test_grow(self):
        raster, known = array("f", (0, 0, 3, 0, 0)), bytearray((0, 0, 1, 0, 0))
        decode.grow(raster, 1, known, 5, 1, 1)
        self.assertEqual((list(raster), list(known)), ([0, 3, 3, 3, 0], [0, 1, 1, 1, 0]))

    def test_depth_turns_away_as_a_round_body(self):
        """A surface that falls .5 cm a pixel to the right goes on as a ball does: (1 + sin a) / cos a. One that
        faces away falls 4 at most."""
        normal = (0.6, 0, 0.8)
        raster, known = array("f", (0, 0, -4, 0, 0)), bytearray((0, 0, 1, 0, 0))
        normals = array("f", normal * 5)
        decode.grow_depth(raster, normals, known, 5, 1, 2, 1.0)
        for found, wanted in zip(raster, (-2.5, -3.25, -4, -6, -8)):
            self.assertAlmostEqual(found, wanted, places=5)
        raster, known = array("f", (0, 0)), bytearray((1, 0))
        decode.grow_depth(raster, array("f", (1, 0, 0) * 2), known, 2, 1, 1, 1.0)
        self.assertAlmostEqual(raster[1], -4, places=5)
