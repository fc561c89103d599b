"""strokes.py, fills.py and regions.py: lines of a brush, the eraser, sets of faces, strokes.xml."""
import os
import unittest
from array import array

from support import temporary_folder

from human_material.services import fills, regions, strokes
from human_material.services.errors import InputError


def strip():
    """Six quads in a row, one unit each: the last two apart, of another material; a UV seam after the second."""
    first, vertices, uvs = array("i", [0]), array("i"), array("f")
    for k in range(6):
        a = 2 * k + (2 if k > 3 else 0)
        vertices.extend((a, a + 2, a + 3, a + 1))
        left = k + (10 if k > 1 else 0)
        uvs.extend((left, 0, left + 1, 0, left + 1, 1, left, 1))
        first.append(len(vertices))
    return fills.Faces(first, vertices, uvs, array("H", [0, 0, 0, 0, 1, 1]))


class Fills(unittest.TestCase):
    def test_material_piece_and_island(self):
        faces = strip()
        self.assertEqual(faces.of_material(5), [4, 5])
        self.assertEqual(faces.of_piece(1), [0, 1, 2, 3])
        self.assertEqual(faces.of_island(1), [0, 1])
        self.assertEqual(faces.of_island(3), [2, 3])
        self.assertEqual(faces.of_piece(5), [4, 5])

    def test_lasso(self):
        square = [(0, 0), (4, 0), (4, 4), (2, 2), (0, 4)]   # with a notch
        self.assertTrue(fills.is_inside(1, 1, square))
        self.assertFalse(fills.is_inside(2, 3, square))
        self.assertFalse(fills.is_inside(5, 1, square))


class Lines(unittest.TestCase):
    def test_a_line_is_thinned_and_breaks_where_it_leaves(self):
        painter = strokes.Painter("hair", 2.0, 1.0)
        for x in (0, 0.1, 0.2, 1.0, 1.1):
            painter.add(int(x), (x, 0.0, 0.0))
        painter.leave()
        painter.add(9, (3.0, 0.0, 0.0))
        painter.add(9, (90.0, 0.0, 0.0))   # the other arm, behind
        lines = [[p[1] for p in stroke["points"]] for stroke in painter.strokes("g")]
        self.assertEqual(lines, [[0, 1.0], [3.0], [90.0]])
        self.assertEqual({stroke["group"] for stroke in painter.strokes("g")}, {"g"})

    def test_dots_of_a_fill(self):
        made = strokes.of_faces("skin", list(range(10000)), lambda f: (f, 0, 0), "g")
        dots = [p[0] for stroke in made for p in stroke["points"]]
        self.assertLessEqual(len(dots), strokes.MOST_DOTS)
        self.assertEqual((dots[0], dots[-1]), (0, 9999))
        self.assertLessEqual(max(len(stroke["points"]) for stroke in made), strokes.DOTS_OF_STROKE)

    def test_the_eraser_takes_what_it_touches_and_its_group(self):
        line = {"class": "hair", "radius_cm": 1.0, "points": [[0, 0, 0, 0], [1, 10, 0, 0]]}
        far = {"class": "skin", "radius_cm": 1.0, "points": [[0, 0, 50, 0]]}
        fill = [dict(line, group="g"), dict(far, group="g")]
        self.assertEqual(strokes.erased([line, far], [(5, 1.9, 0)], 1.0, 1.0), [far])
        self.assertEqual(strokes.erased([line, far], [(5, 2.1, 0)], 1.0, 1.0), [line, far])
        self.assertEqual(strokes.erased([line, far], [(0.05, 0.019, 0)], 1.0, 100.0), [far])   # a scan in metres
        self.assertEqual(strokes.erased(fill, [(5, 0, 0)], 1.0, 1.0), [])


class Files(unittest.TestCase):
    def test_what_is_written_is_read(self):
        path = os.path.join(temporary_folder(self), "s.xml")
        made = [{"class": "hair", "radius_cm": 1.5, "points": [[3, 0.1, -2.5, 1e-6]]},
                {"class": "skin", "radius_cm": 0.01, "points": [[0, 0.0, 0.0, 0.0], [7, 1.0, 2.0, 3.0]]}]
        regions.write_strokes(path, made, "ab")
        self.assertEqual(strokes.read(path), (made, "ab"))

    def test_wrong_files(self):
        path = os.path.join(temporary_folder(self), "s.xml")
        for text, words in (("<a", "well-formed"), ('<strokes schema="2.0"/>', "schema 1"),
                            ('<strokes schema="1.0"><stroke class="skin" radius_cm="1"><point face="1" at="1,2"/>'
                             '</stroke></strokes>', "stroke 1: is no stroke"),
                            ('<strokes schema="1.0"><stroke class="skin" radius_cm="1"><point face="1" at="1,2,nan"/>'
                             '</stroke></strokes>', "stroke 1: is no stroke")):
            with open(path, "w", encoding="ascii") as file:
                file.write(text)
            with self.assertRaisesRegex(InputError, words):
                strokes.read(path)
        with self.assertRaisesRegex(InputError, "cannot be read"):
            strokes.read(path + ".none")
