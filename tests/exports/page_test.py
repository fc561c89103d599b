"""The exported page in headless Chromium: every picture loads, filters filter, a click shows all maps side by side.

usage: page_test.py SOURCE_DIR OPENHUMANBRDF
"""
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

SOURCE, PROGRAM = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
PLAN = """<?xml version="1.0"?>
<plan schema="1" name="tiny" seed="1">
  <maps size_px="64"/>
  <person id="ann" scan="{human}.glb" labels="{human}.labels.txt" split="train" sex="female" age="30"/>
  <person id="bob" scan="{human}.glb" labels="{human}.labels.txt" split="test" sex="male" age="40"/>
  <environments id="bundled" folder="{lights}"/>
  <views split="train" count="3" size_px="48" spp="2"><lights from="bundled" count="2"/></views>
  <views split="test" count="2" size_px="48" spp="2"><lights from="bundled" count="1"/></views>
</plan>"""
# What is tried once the page is there; the answers are read from --dump-dom.
PROBE = """<script>window.addEventListener("load", async () => {
  const answers = {}, count = () => document.querySelectorAll("#grid figure").length;
  const choose = (name, value) => { const s = document.querySelector(`select[data-filter="${name}"]`); s.value = value; s.onchange(); return count(); };
  for (const image of document.images) { image.loading = "eager"; await image.decode().catch(() => 0); }
  answers.pictures = document.images.length;
  answers.broken = [...document.images].filter(i => i.naturalWidth === 0).length;
  answers.all = count();
  answers.train = choose("split", "train"); answers.none = choose("person", "bob"); choose("split", "*");
  answers.bob = count(); choose("person", "*");
  answers.female = choose("sex", "female"); choose("sex", "*");
  answers.sunset = choose("light", "sunset"); choose("light", "*");
  document.querySelector("#grid figure").click();
  for (let k = 0; k < 100 && !document.querySelector(".map"); ++k) await new Promise(done => setTimeout(done, 50));
  answers.maps = document.querySelectorAll(".map").length;
  answers.names = [...document.querySelectorAll(".map + div")].map(e => e.textContent).join(" ");
  document.documentElement.dataset.answers = JSON.stringify(answers).replaceAll('"', "'");
});</script>"""


class Page(unittest.TestCase):
    def test_pictures_filters_and_maps(self):
        with tempfile.TemporaryDirectory(prefix="ohb-page-") as temporary:
            root = Path(temporary)
            plan, page = root / "plan.xml", root / "page"
            plan.write_text(PLAN.format(human=SOURCE / "assets/example_human/example_human", lights=SOURCE / "assets/environments"))
            subprocess.run([PROGRAM, "produce", plan, "-o", root / "set"], check=True, capture_output=True)
            subprocess.run([PROGRAM, "export", root / "set", "--page", "-o", page], check=True, capture_output=True)
            shutil.rmtree(root / "set")     # the page needs nothing outside its folder
            probe = page / "probe.html"
            probe.write_text((page / "index.html").read_text().replace("</body>", PROBE + "</body>"))
            # Virtual time does not wait for pictures to be decoded: on a busy machine the first tries can end too early.
            for attempt in range(5):
                result = subprocess.run(["chromium", "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={root}/profile",
                                         "--enable-logging=stderr", "--virtual-time-budget=20000", "--dump-dom", probe.as_uri()],
                                        capture_output=True, text=True, timeout=180)
                self.assertNotIn("CONSOLE", result.stderr)
                found = re.search(r'data-answers="([^"]*)"', result.stdout)
                if found:
                    break
            self.assertIsNotNone(found, result.stdout[:500] + result.stderr[-500:])
            answers = dict(re.findall(r"'(\w+)':'?([^',}]*)", found.group(1)))
            self.assertEqual(answers["pictures"], "5")
            self.assertEqual(answers["broken"], "0")
            self.assertEqual([answers[k] for k in ("all", "train", "none", "bob", "female")], ["5", "3", "0", "2", "3"])
            data = (page / "data.js").read_text()
            self.assertEqual(int(answers["sunset"]), len(re.findall(r'"lights":\[[^\]]*"sunset"', data)))
            self.assertEqual(answers["maps"], "9")      # mask, six maps, two lights
            for name in ("mask", "normal", "diffuse", "roughness", "specular", "sss", "displacement", "relit_"):
                self.assertIn(name, answers["names"])


if __name__ == "__main__":
    if shutil.which("chromium") is None:
        print("SKIPPED: the exported page is NOT tested: there is no chromium")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1], verbosity=2)
