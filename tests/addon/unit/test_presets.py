"""Presets and what is written after --edit."""
import unittest

import support  # noqa: F401

from human_material.services import decode, presets
from human_material.services.errors import InputError


class Presets(unittest.TestCase):
    def test_parse(self):
        name, preset = presets.parse_edit("fabric:shiny_leather")
        self.assertEqual((name, preset.roughness, preset.color), ("fabric", 0.25, None))
        self.assertAlmostEqual(preset.f0, 0.041, delta=5e-4)
        name, preset = presets.parse_edit("hair:#ff8000")
        self.assertEqual((name, preset.roughness, preset.color[0], preset.color[2]), ("hair", None, 1, 0))
        self.assertAlmostEqual(preset.color[1], decode.srgb_to_linear(128 / 255))

    def test_wrong_ones_are_named(self):
        for text in ("", "fabric", "wool:red", "hair:purple_rain", "hair:#12", "hair:#gggggg", ":"):
            with self.assertRaises(InputError):
                presets.parse_edit(text)
