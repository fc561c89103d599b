"""The albedo that Blender 4 and later are given makes their picture that of 3.4, in a white room."""
import unittest

from support import reflection

from human_material.services import balance

#: skin, leather, fabric, hair (docs/conventions.md, "Material table"), and what edits reach
MATERIALS = ((0.4, 0.028), (0.25, 0.041), (0.85, 0.056), (0.5, 0.046), (0.3, 0.08), (1.0, 0.02))
COSINES = (1.0, 0.7, 0.45, 0.25)
ALBEDO = 0.4


class Balance(unittest.TestCase):
    def test_known_values_of_principled_v1(self):
        """Cycles 3.4.1 in a white room: roughness, F0, cosine -> diffuse of albedo .8 and highlight, and highlight."""
        for roughness, cosine, both, alone in ((0.1, 1.0, 0.8258, 0.0400), (0.5, 1.0, 0.8419, 0.0370),
                                               (1.0, 1.0, 0.8413, 0.0127), (0.5, 0.258819, 0.9315, 0.1137)):
            highlight = reflection.highlight(cosine, roughness, 0.04, True)
            self.assertAlmostEqual(highlight, alone, delta=5e-4)
            self.assertAlmostEqual(0.8 * reflection.burley(cosine, roughness) + highlight, both, delta=1e-3)

    def test_both_models_look_alike(self):
        worst = worst_before = 0.0
        for roughness, f0 in MATERIALS:
            for cosine in COSINES:
                wanted = ALBEDO * reflection.burley(cosine, roughness) + reflection.highlight(cosine, roughness, f0, True)
                below = 1 - reflection.layer(cosine, roughness, f0)
                highlight = reflection.highlight(cosine, roughness, f0, False)
                for is_balanced in (False, True):
                    gain = balance.gain(cosine, roughness, f0) if is_balanced else 1
                    error = abs((gain * ALBEDO * below + highlight) / wanted - 1)
                    if is_balanced:
                        worst = max(worst, error)
                    else:
                        worst_before = max(worst_before, error)
        self.assertLess(worst, 0.02)
        self.assertGreater(worst_before, 0.1)   # what it is for

    def test_nothing_breaks_beyond_the_fits(self):
        for cosine in (0.0, 0.5, 1.0):
            for roughness in (0.0, 0.5, 1.0):
                for f0 in (0.0, 0.08, 0.2, 0.3):
                    self.assertTrue(0.4 < balance.gain(cosine, roughness, f0) < 4, (cosine, roughness, f0))
