"""Runs ./demo --quick and opens its page in headless Chromium: no missing picture, no console error.

usage: demo_test.py SOURCE_DIR SCREENSHOT.png
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

SOURCE, SCREENSHOT = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
# Counts pictures that did not load, where --dump-dom shows it.
PROBE = """<script>window.addEventListener("load", () => {
  const broken = [...document.images].filter(i => !i.complete || i.naturalWidth === 0).length;
  document.documentElement.dataset.pictures = document.images.length;
  document.documentElement.dataset.broken = broken;
});</script>"""


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

    def test_keeps_a_screenshot(self):
        result = chromium(self.mailed / "index.html", f"--screenshot={SCREENSHOT}", "--window-size=1240,3200")
        self.assertTrue(SCREENSHOT.exists(), result.stderr[-500:])
        self.assertGreater(SCREENSHOT.stat().st_size, 50000)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
