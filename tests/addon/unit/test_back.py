"""The guessed back: limbs are round, the front is mirrored at the outline."""
import math
import types
import unittest
from array import array

import support  # noqa: F401

from human_material.services import back, grid
from human_material.services.maps_json import Camera

CAMERA = Camera("orthographic", width_cm=120)
SIZE = 120   # pixels of 1 cm


def maps_of(half_width_cm, half_depth_cm, middle_cm=0.0):
    """An upright elliptic cylinder, and its bare x of each column."""
    mask, depth = array("f", bytes(4 * SIZE * SIZE)), array("f", bytes(4 * SIZE * SIZE))
    for y in range(10, 110):
        for x in range(SIZE):
            u = (x + 0.5 - SIZE / 2) / half_width_cm
            if abs(u) < 1:
                mask[y * SIZE + x] = 1.0
                depth[y * SIZE + x] = middle_cm + half_depth_cm * math.sqrt(1 - u * u)
    return types.SimpleNamespace(size=(SIZE, SIZE), mask=mask, displacement_cm=depth,
                                 info=types.SimpleNamespace(camera=CAMERA))


class Back(unittest.TestCase):
    def expect(self, half_width_cm, half_depth_cm, middle_cm, tolerance_cm):
        loaded = maps_of(half_width_cm, half_depth_cm, middle_cm)
        found, side = back.depths(loaded.displacement_cm, loaded.mask, SIZE, SIZE, 1.0)
        self.assertEqual((side, len(found)), (1, sum(1 for m in loaded.mask if m > 0)))
        for (x, y), z in found.items():
            u = (x + 0.5 - SIZE / 2) / half_width_cm
            self.assertAlmostEqual(z, middle_cm - half_depth_cm * math.sqrt(1 - u * u), delta=tolerance_cm)
            self.assertLess(z, loaded.displacement_cm[y * SIZE + x])

    def test_a_limb_is_round(self):
        for middle_cm in (0.0, -20.0):
            self.expect(8, 8, middle_cm, 0.01)

    def test_a_trunk_is_as_thick_as_its_front_says(self):
        self.expect(20, 14, 3.0, 6.3)   # the outermost pixel's centre is 3.1 cm before the outline's depth

    def test_a_flat_picture_is_no_thicker_than_a_trunk(self):
        loaded = maps_of(30, 0)
        found, _ = back.depths(loaded.displacement_cm, loaded.mask, SIZE, SIZE, 1.0)
        self.assertAlmostEqual(min(found.values()), -back.THICKEST_CM, delta=0.1)

    def test_faces_look_to_the_back_and_stay_behind_the_front(self):
        loaded = maps_of(8, 8)
        rear = back.build(loaded)
        self.assertGreater(len(rear.faces), 1000)
        frame = grid.Frame(CAMERA, SIZE, SIZE)
        for face in rear.faces[::97]:
            (ax, ay, _), (bx, by, _), (cx, cy, _) = (rear.vertices[v] for v in face[:3])
            self.assertLess((bx - ax) * (cy - ay) - (by - ay) * (cx - ax), 0)   # clockwise to the viewer
        for vertex, uv in zip(rear.vertices[::97], rear.uvs[::97]):
            x, y = uv[0] * SIZE - 0.5, uv[1] * SIZE - 0.5
            for found, wanted in zip(vertex, frame.point(x, y, 100 * vertex[2])):
                self.assertAlmostEqual(found, wanted)

    def test_large_maps_are_looked_at_in_cells(self):
        size, mask = 640, array("f", [1.0]) * (640 * 640)
        found, side = back.depths(array("f", bytes(4 * 640 * 640)), mask, size, size, 0.25)
        self.assertEqual((side, len(found)), (4, 160 * 160))
