"""The relief is the displacement map, exactly, and is cut where the depth jumps."""
import unittest
from array import array

import support  # noqa: F401

from human_material.services import grid
from human_material.services.maps_json import Camera

PERSPECTIVE = Camera("perspective", distance_cm=400, half_width=0.2)
ORTHOGRAPHIC = Camera("orthographic", width_cm=160)


def project(camera, point, width, height):
    """Pixel coordinates (row 0 at the bottom) of a point in metres."""
    x, y, z = (100 * c for c in point)
    scale = camera.frame_width_cm / width * camera.scale_at(z)
    return x / scale + width / 2 - 0.5, y / scale + height / 2 - 0.5


def relief_of(depths, width, height, camera, jump_cm=5):
    return grid.build(array("f", depths), bytearray([1]) * (width * height), width, height, camera, jump_cm)


class Grid(unittest.TestCase):
    def test_each_pixel_is_a_vertex_at_its_depth_on_its_ray(self):
        width, height = 7, 5
        depths = [0.37 * (i % width) - 0.2 * (i // width) for i in range(width * height)]
        for camera in (PERSPECTIVE, ORTHOGRAPHIC):
            relief = relief_of(depths, width, height, camera)
            self.assertEqual(relief.pixel_vertices, width * height)
            self.assertEqual(len(relief.faces), (width - 1) * (height - 1))
            for p in range(width * height):
                self.assertAlmostEqual(relief.vertices[p][2] * 100, depths[p], places=5)
                x, y = project(camera, relief.vertices[p], width, height)
                self.assertAlmostEqual(x, p % width, places=6)
                self.assertAlmostEqual(y, p // width, places=6)
                self.assertAlmostEqual(relief.uvs[p][0], (p % width + 0.5) / width)
                self.assertAlmostEqual(relief.uvs[p][1], (p // width + 0.5) / height)

    def test_uncovered_pixels_have_no_surface(self):
        known = bytearray([1]) * 9
        known[4] = 0
        relief = grid.build(array("f", [0] * 9), known, 3, 3, ORTHOGRAPHIC)
        self.assertEqual((len(relief.vertices), len(relief.faces)), (8, 0))

    def test_faces_look_at_the_viewer(self):
        relief = relief_of([0, 0, 0, 30, 0, 0, 30, 30, 0], 3, 3, PERSPECTIVE)
        for face in relief.faces:
            area = sum(relief.vertices[a][0] * relief.vertices[b][1] - relief.vertices[b][0] * relief.vertices[a][1]
                       for a, b in zip(face, face[1:] + face[:1]))
            self.assertGreater(area, 0)

    def test_a_jump_is_cut_without_sheet_and_without_crack(self):
        """A step of 30 cm between the columns 1 and 2: no face spans it, and every ray meets a face."""
        width = height = 4
        depths = [30.0 if p % width < 2 else 0.0 for p in range(16)]
        relief = relief_of(depths, width, height, PERSPECTIVE)
        self.assertEqual(relief.vertices[:16], relief_of(depths, width, height, PERSPECTIVE, 100).vertices)
        for face in relief.faces:
            z = [relief.vertices[v][2] for v in face]
            self.assertLess(max(z) - min(z), 1e-9)
        for step in range(40):
            x, y = 3 * (step + 0.5) / 40, 1.3
            front = max((relief.vertices[f[0]][2] for f in relief.faces if self.meets(relief, f, x, y)),
                        default=None)
            self.assertAlmostEqual(front, 0.3 if x < 1.5 else 0.0, places=9, msg="at x = %g" % x)

    def meets(self, relief, face, x, y):
        corners = [project(PERSPECTIVE, relief.vertices[v], 4, 4) for v in face]
        return all((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]) >= -1e-9
                   for a, b in zip(corners, corners[1:] + corners[:1]))

    def test_sheets(self):
        self.assertEqual(grid.sheets([0, 1, 2, 3], 5), [[3, 2, 1, 0]])
        self.assertEqual(grid.sheets([0, 30, 31, 0], 5), [[2, 1], [0, 3]])
        self.assertEqual(grid.sheets([0, 10, 20, 30], 5), [[3], [2], [1], [0]])

    def test_three_depths_at_one_corner_keep_the_pixels_exact(self):
        relief = relief_of([0, 10, 20, 30], 2, 2, PERSPECTIVE)
        for p in range(4):   # nothing lies in front of a pixel's centre
            mine = relief.vertices[p][2]
            x, y = p % 2, p // 2
            for face in relief.faces:
                corners = [project(PERSPECTIVE, relief.vertices[v], 2, 2) for v in face]
                if any(abs(cx - x) < 1e-6 and abs(cy - y) < 1e-6 for cx, cy in corners):
                    self.assertLessEqual(min(relief.vertices[v][2] for v in face), mine + 1e-9)
