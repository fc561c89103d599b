"""Soft class masks from the material maps."""
import os
import random
import unittest
import xml.etree.ElementTree as xml
from array import array

import support  # noqa: F401

from human_material.services import classes, decode, overlay, strokes

F0 = [decode.srgb_to_linear(entry["specular"]) for entry in classes.TABLE]
S = [entry["specular"] for entry in classes.TABLE]
ROUGHNESS = [entry["roughness"] for entry in classes.TABLE]
SSS = [entry["sss"] for entry in classes.TABLE]


def decoded(shares, width, height, noise=0.0):
    """shares: list of four a pixel, mixed as a renderer averages; noise as an estimate has it."""
    rng = random.Random(5)

    def mixed(values):
        return array("f", [sum(w * v for w, v in zip(pixel, values)) + rng.gauss(0, noise) for pixel in shares])
    f0 = array("f", [decode.srgb_to_linear(max(s, 0)) for s in mixed(S)])
    return classes.shares_of_materials(f0, mixed(ROUGHNESS), mixed(SSS), list(range(width * height)), width, height)


def one(c):
    return [float(i == c) for i in range(4)]


class Classes(unittest.TestCase):
    def test_table_is_the_papers(self):
        self.assertEqual(classes.NAMES, ("skin", "hair", "fabric", "leather"))
        self.assertEqual([round(s * 255) for s in S], [47, 61, 67, 57])

    def test_table_is_that_of_the_programs(self):
        root = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..")
        stated = {m.get("class"): m for m in xml.parse(os.path.join(root, "assets/materials.xml")).getroot()}
        self.assertEqual(set(stated), set(classes.NAMES))
        for entry in classes.TABLE:
            for name in ("specular", "roughness", "sss"):
                self.assertEqual(float(stated[entry["name"]].get(name)), entry[name], entry["name"])

    def test_painting_knows_each_class_of_the_table(self):
        self.assertEqual(strokes.CLASSES, classes.NAMES)
        colors = [overlay.class_color(c) for c in range(len(classes.NAMES))]
        self.assertEqual(len({*colors, overlay.UNKNOWN}), len(classes.NAMES) + 1)
        self.assertEqual(overlay.class_color(255), overlay.UNKNOWN)

    def test_pure_regions_are_exact(self):
        width = height = 24
        truth = [one((x >= 12) + 2 * (y >= 12)) for y in range(height) for x in range(width)]
        self.assertLess(self.worst(truth, decoded(truth, width, height)), 1e-4)

    def test_fabric_against_leather_does_not_become_hair(self):
        """A mixture of both has hair's roughness; shares come out as they went in."""
        width, height = 24, 12
        truth = []
        for _ in range(height):
            for x in range(width):
                t = min(max((x - 11) / 2, 0), 1)
                truth.append([0, 0, 1 - t, t])
        found = decoded(truth, width, height)
        self.assertLess(max(found[1::4]), 1e-6)
        self.assertLess(self.worst(truth, found), 1e-3)

    def test_noise(self):
        """Of pixels inside regions at least 97 % keep their class at a noise of 0.02, 90 % at 0.05."""
        width = height = 40
        truth = [one((x >= 20) + 2 * (y >= 20)) for y in range(height) for x in range(width)]
        for noise, right in ((0.02, 0.97), (0.05, 0.90)):
            found = decoded(truth, width, height, noise)
            hits = sum(found[4 * p + truth[p].index(1)] > 0.5 for p in range(width * height))
            self.assertGreaterEqual(hits / (width * height), right, noise)

    def picture_of(self, rows, sleeve):
        """A person of 32 x 32: hair above skin above fabric, and a sleeve of an estimate between two materials."""
        width = height = 32
        between = [0, 0, 1 - sleeve, sleeve]
        truth = [between if x < 10 and y >= 12 else one(1 if y < rows[0] else 0 if y < rows[1] else 2)
                 for y in range(height) for x in range(width)]
        return truth, decoded(truth, width, height)

    def test_a_sleeve_that_looks_like_hair_is_none(self):
        """Half fabric, half leather is what hair is made of; away from the hair on the head it is not hair."""
        truth, found = self.picture_of((3, 8), 0.55)
        sleeve = [p for p in range(32 * 32) if truth[p] == [0, 0, 0.44999999999999996, 0.55]]
        self.assertEqual(len(sleeve), 200)
        self.assertEqual(max(found[4 * p + 1] for p in sleeve), 0)
        self.assertGreater(min(found[4 * p + 1] for p in range(32 * 2)), 0.99)

    def test_below_the_upper_third_nothing_is_hair(self):
        """Shoes and sleeves that look like hair are none on somebody whose hair was not found."""
        truth, found = self.picture_of((0, 8), 0.55)
        sleeve = [p for p in range(32 * 32) if 0.5 < truth[p][3] < 0.6]
        self.assertEqual(max(found[4 * p + 1] for p in sleeve), 0)

    def test_hair_under_a_hat_stays(self):
        width = height = 32
        truth = [one(2 if y < 5 else 1 if y < 9 else 2) for y in range(height) for x in range(width)]
        found = decoded(truth, width, height)
        self.assertLess(self.worst(truth, found), 1e-4)

    def test_hair_that_hangs_down_stays(self):
        """A braid to the hips is one piece with the hair on the head."""
        width = height = 32
        truth = [one(1 if y < 3 or (14 <= x < 18 and y < 25) else 2) for y in range(height) for x in range(width)]
        found = decoded(truth, width, height)
        self.assertLess(self.worst(truth, found), 1e-4)

    def test_shares_sum_to_one(self):
        rng = random.Random(3)
        values = array("f", [rng.random() for _ in range(300)])
        found = classes.shares_of_map(values, list(range(100)))
        for p in range(100):
            self.assertAlmostEqual(sum(found[4 * p:4 * p + 4]), 1, places=5)

    def worst(self, truth, found):
        return max(abs(found[4 * p + c] - truth[p][c]) for p in range(len(truth)) for c in range(4))
