"""Images are judged before Blender sees them."""
import os
import unittest

from support import image_files, temporary_folder

from human_material.services.errors import InputError
from human_material.services.image_header import read_header


class ImageHeader(unittest.TestCase):
    def setUp(self):
        self.path = os.path.join(temporary_folder(self), "image")

    def refuse(self, words):
        with self.assertRaises(InputError) as caught:
            read_header(self.path)
        self.assertIn(words, str(caught.exception))

    def cut(self, keep):
        with open(self.path, "rb") as file:
            data = file.read()
        with open(self.path, "wb") as file:
            file.write(data[:keep])

    def test_png(self):
        for channels, bits, alpha in ((1, 8, False), (3, 16, False), (3, 8, True), (1, 16, True)):
            image_files.png(self.path, 3, 2, [7] * (6 * (channels + alpha)), channels, bits, alpha)
            header = read_header(self.path)
            self.assertEqual((header.kind, header.width_px, header.height_px), ("PNG", 3, 2))
            self.assertEqual((header.channels, header.bits, header.has_alpha), (channels, bits, alpha))

    def test_exr(self):
        for channels, count in (("RGB", 3), ("RGBA", 3), ("Y", 1)):
            image_files.exr(self.path, 3, 2, [0.5] * (6 * len(channels)), channels)
            header = read_header(self.path)
            self.assertEqual((header.kind, header.width_px, header.channels, header.bits), ("EXR", 3, count, 32))
            self.assertEqual(header.has_alpha, channels == "RGBA")

    def test_cut_off_anywhere(self):
        image_files.png(self.path, 3, 2, [7] * 6)
        for keep in (0, 4, 20, os.path.getsize(self.path) - 1):
            image_files.png(self.path, 3, 2, [7] * 6)
            self.cut(keep)
            self.assertRaises(InputError, read_header, self.path)
        image_files.exr(self.path, 3, 2, [0.5] * 18)
        for keep in range(0, os.path.getsize(self.path)):
            image_files.exr(self.path, 3, 2, [0.5] * 18)
            self.cut(keep)
            self.assertRaises(InputError, read_header, self.path)

    def test_other_kinds_of_file(self):
        for data, words in ((b"", "empty"), (b"\xff\xd8\xff\xe0 a JPEG", "neither PNG nor OpenEXR")):
            with open(self.path, "wb") as file:
                file.write(data)
            self.refuse(words)

    def test_other_kinds_of_exr(self):
        for flag, words in ((0x200, "tiled"), (0x800, "deep"), (0x1000, "multi-part")):
            image_files.exr(self.path, 3, 2, [0.5] * 18, flags=flag)
            self.refuse(words)
        image_files.exr(self.path, 3, 2, [0.5] * 18, window=b"\x01\0\0\0" + b"\0" * 12)
        self.refuse("cropped")
        image_files.exr(self.path, 3, 2, [0.5] * 12, channels="UV")
        self.refuse("channels")
