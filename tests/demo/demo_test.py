"""Runs ./demo --quick and opens its page in headless Chromium: no missing picture, no console error.

usage: demo_test.py SOURCE_DIR SCREENSHOT.png
"""
import json
import os
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib
from pathlib import Path

SOURCE, SCREENSHOT = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
# Counts pictures that did not load, where --dump-dom shows it.
PROBE = """<script>window.addEventListener("load", () => {
  const broken = [...document.images].filter(i => !i.complete || i.naturalWidth === 0).length;
  document.documentElement.dataset.pictures = document.images.length;
  document.documentElement.dataset.broken = broken;
});</script>"""


def pixels_of_png(path):
    """RGB of every pixel of an 8-bit RGB picture, by the standard library alone."""
    data, position, packed = path.read_bytes(), 8, b""
    while position < len(data):
        size, kind = struct.unpack(">I4s", data[position:position + 8])
        body = data[position + 8:position + 8 + size]
        if kind == b"IHDR":
            width, height, depth, colour_type = struct.unpack(">IIBB", body[:10])
            assert (depth, colour_type) == (8, 2), (depth, colour_type)
        packed += body if kind == b"IDAT" else b""
        position += size + 12
    raw, above, stride = zlib.decompress(packed), bytes(3 * width), 3 * width
    for y in range(height):
        line = bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        unfilter(raw[y * (stride + 1)], line, above)
        yield from zip(line[0::3], line[1::3], line[2::3])
        above = line


def unfilter(kind, line, above):
    for i in range(len(line)):
        left, corner = (line[i - 3], above[i - 3]) if i >= 3 else (0, 0)
        up = above[i]
        estimate = left + up - corner
        paeth = min((left, up, corner), key=lambda v: abs(estimate - v))
        line[i] = (line[i] + (0, left, up, (left + up) // 2, paeth)[kind]) & 255


def chromium(page, *options):
    with tempfile.TemporaryDirectory() as profile:
        return subprocess.run(["chromium", "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={profile}",
                               "--hide-scrollbars", "--enable-logging=stderr", "--virtual-time-budget=20000", *options,
                               page.as_uri()], capture_output=True, text=True, timeout=180)


class DemoPage(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = Path(tempfile.mkdtemp(prefix="ohb-demo-"))
        result = subprocess.run(["./demo", "--quick", "-o", str(cls.folder / "demo")], cwd=SOURCE, capture_output=True,
                                text=True, timeout=900, env={**os.environ, "OHB_DEMO_NO_BUILD": "1"})
        assert result.returncode == 0, result.stdout[-2000:] + result.stderr[-2000:]
        # Mailed: the page must not need anything outside its folder.
        cls.mailed = cls.folder / "mailed"
        shutil.copytree(cls.folder / "demo", cls.mailed)
        shutil.rmtree(cls.folder / "demo")

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    def test_opens_without_missing_pictures_or_errors(self):
        probe = self.mailed / "probe.html"
        probe.write_text((self.mailed / "index.html").read_text(encoding="utf-8").replace("</body>", PROBE + "</body>"))
        result = chromium(probe, "--dump-dom")
        tag = re.search(r"<html[^>]*>", result.stdout).group(0)
        self.assertGreater(int(re.search(r'data-pictures="(\d+)"', tag).group(1)), 20)
        self.assertEqual(re.search(r'data-broken="(\d+)"', tag).group(1), "0")
        self.assertEqual([line for line in result.stderr.splitlines() if "CONSOLE" in line], [])

    def test_names_nothing_outside_its_folder(self):
        text = (self.mailed / "index.html").read_text(encoding="utf-8")
        for source in re.findall(r'(?:src|href)="([^"]*)"', text):
            self.assertFalse(source.startswith(("http", "file:", "/", "..")), source)
        self.assertNotIn("nan", re.sub(r"<[^>]*>", " ", text).lower().split())

    def test_links_lead_somewhere(self):
        links = re.findall(r'<a href="([^"]*)"', (self.mailed / "index.html").read_text(encoding="utf-8"))
        self.assertGreater(len(links), 8)
        self.assertEqual([link for link in links if not (self.mailed / link).exists()], [])

    def test_the_legend_has_the_colours_of_the_label_map(self):
        """Each class that has faces shows its legend's colour in the map of classes, as Chromium draws both."""
        text = (self.mailed / "index.html").read_text(encoding="utf-8")
        legend = re.findall(r'class="chip" style="background:(#[0-9a-f]{6})"', text)
        self.assertEqual(len(legend), 4)
        picture = next((self.mailed / "regions" / "maps").glob("*/classes_preview.png"))
        colours = {tuple(rgb) for rgb in pixels_of_png(picture)}
        for colour in legend:
            rgb = tuple(int(colour[i:i + 2], 16) for i in (1, 3, 5))
            self.assertTrue(any(max(abs(a - b) for a, b in zip(rgb, seen)) <= 1 for seen in colours), colour)

    def test_estimates_from_a_photograph_without_a_mask(self):
        """The person was found, and in the photograph they are what the mask says: neither nothing nor the wall."""
        text = (self.mailed / "index.html").read_text(encoding="utf-8")
        self.assertIn("mask, found", text)
        self.assertNotIn("Nobody was found", text)
        maps = self.mailed / "photograph" / "maps"
        for name in ("normal", "diffuse", "roughness", "specular", "sss", "displacement"):
            self.assertIn(f"photograph_maps_{name}.png", text)
        crop = json.loads((maps / "maps.json").read_text(encoding="utf-8"))["source"]["photo_crop_px"]
        rows = pixels_of_png(self.mailed / "photograph" / "photograph.png")
        width = int(sum(1 for _ in rows) / 1.25) ** 0.5        # the photograph is 4 : 5
        self.assertGreater(crop["side"], 0.8 * width)
        self.assertLess(crop["side"], 1.15 * width)

    def test_keeps_a_screenshot(self):
        result = chromium(self.mailed / "index.html", f"--screenshot={SCREENSHOT}", "--window-size=1240,3200")
        self.assertTrue(SCREENSHOT.exists(), result.stderr[-500:])
        self.assertGreater(SCREENSHOT.stat().st_size, 50000)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
