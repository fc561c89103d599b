#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes OUT/index.html and OUT/pictures/ from what ./demo left in OUT: one folder that can be mailed.

usage: page.py OUT SECONDS_IN_ALL
Only Python's standard library; every picture is copied, every number is read from a report.
"""
import html
import json
import os
import shutil
import sys
from pathlib import Path

MAPS = ("normal", "diffuse", "roughness", "specular", "sss", "displacement")
STYLE = """
body{font:16px/1.5 system-ui,sans-serif;max-width:1180px;margin:2rem auto;padding:0 1rem;color:#222;background:#fff}
h1{margin-bottom:.2rem} h2{margin-top:2.5rem;border-bottom:1px solid #ddd;padding-bottom:.3rem}
.row{display:flex;flex-wrap:wrap;gap:12px} figure{margin:0} figcaption{font-size:.85rem;color:#555;text-align:center}
img{display:block;max-width:100%;background:repeating-conic-gradient(#eee 0 25%,#fff 0 50%) 0 0/16px 16px}
table{border-collapse:collapse} td,th{padding:.25rem .8rem;text-align:right;border-bottom:1px solid #eee}
td:first-child,th:first-child{text-align:left} pre{background:#f6f6f6;padding:1rem;overflow:auto;font-size:.8rem}
"""


class Page:
    """Collects HTML and copies the pictures that it names into OUT/pictures."""

    def __init__(self, out):
        self.out = out
        self.pictures = out / "pictures"
        if self.pictures.exists():
            shutil.rmtree(self.pictures)
        self.pictures.mkdir()
        self.body = []

    def add(self, text):
        self.body.append(text)

    def heading(self, text, words=""):
        self.add(f"<h2>{html.escape(text)}</h2>")
        if words:
            self.add(f"<p>{words}</p>")

    def figure(self, source, caption, width_px):
        name = "_".join(source.relative_to(self.out).parts)
        shutil.copyfile(source, self.pictures / name)
        text = html.escape(caption)
        return (f'<figure><img src="pictures/{name}" alt="{text}" width="{width_px}">'
                f"<figcaption>{text}</figcaption></figure>")

    def row(self, figures):
        self.add('<div class="row">' + "".join(figures) + "</div>")

    def table(self, header, rows):
        def line(cells, tag):
            return "<tr>" + "".join(f"<{tag}>{html.escape(str(c))}</{tag}>" for c in cells) + "</tr>"
        self.add("<table>" + line(header, "th") + "".join(line(r, "td") for r in rows) + "</table>")

    def write(self, title):
        text = (f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{html.escape(title)}</title>'
                f'<link rel="icon" href="data:,"><style>{STYLE}</style></head><body>' + "\n".join(self.body) + "</body></html>\n")
        temporary = self.out / ".index.html.tmp"
        temporary.write_text(text, encoding="utf-8")
        os.replace(temporary, self.out / "index.html")


def read_json(path):
    return json.loads(path.read_text(encoding="utf-8"))


def add_regions(page):
    report = read_json(page.out / "regions" / "report.json")
    page.heading("1. Regions", "Each face of the scan belongs to one of four classes.")
    rows = [(name, f"{c['faces']:,}", f"{100 * c['area_share']:.1f} %") for name, c in report["classes"].items()]
    page.table(("class", "faces", "area"), rows)
    pictures = sorted((page.out / "regions" / "maps").glob("**/*.png"))
    coloured = [p for p in pictures if "preview" in p.name or "preview" in p.parent.name] or pictures
    page.row([page.figure(p, p.stem, 300) for p in coloured[:4]])


def add_maps(page):
    page.heading("2. Six UV maps", "Baked from the scan's picture, its surface and the material table; "
                 "as half and float EXR in <code>model/maps</code>, shown here as their previews.")
    for previews in sorted((page.out / "model" / "maps").glob("*/previews"))[:2]:
        found = [previews / f"{name}.png" for name in ("albedo", "normal", "roughness", "specular", "sss", "displacement")]
        page.row([page.figure(p, f"{previews.parent.name}: {p.stem}", 180) for p in found if p.exists()])


def add_samples(page):
    samples = page.out / "samples"
    report = read_json(samples / "render.json")
    previews = samples / "previews"
    page.heading("3. Samples", "Each view is one multi-part EXR: mask, six image-space maps and one part a light. "
                 "Frontal view:")
    page.row([page.figure(previews / f"view_000.{name}.png", name, 180) for name in ("mask",) + MAPS])
    lights = sorted({p.name.split(".relit.")[1][:-4] for p in previews.glob("view_000.relit.*.png")})
    for light in lights:
        page.add(f"<h3>Relit: {html.escape(light)}</h3>")
        pictures = sorted(previews.glob(f"view_*.relit.{light}.png"))
        page.row([page.figure(p, p.name.split(".")[0].replace("_", " "), 135) for p in pictures])
    seconds = sum(v["lights_s"] for v in report["views"])
    paths = sum(v["paths"] for v in report["views"])
    rays = sum(v["closest_hit_rays"] + v["shadow_rays"] for v in report["views"])
    if seconds > 0:
        page.add(f"<p>{len(report['views'])} views, {len(lights)} lights from one pass: {seconds:.1f} s, "
                 f"{paths / seconds / 1e6:.2f} million paths/s, {rays / seconds / 1e6:.2f} million rays/s.</p>")


def add_validation(page):
    folder = page.out / "validation"
    report = read_json(folder / "validate.json")
    words = {"pass": "Equal.", "difference": "Different.", "undecided": "No difference found; more samples would tell "
             "more closely."}.get(report["verdict"], report["verdict"])
    settings = report["settings"]
    page.heading("4. Equal to Cycles?", f"<b>{html.escape(words)}</b> The same view in Blender {report['blender']} and here, "
                 f"{settings['seeds']} seeds of {settings['spp']} paths a pixel on each side, subsurface set to 0.")
    captions = {"ours": "ours", "cycles": "Cycles", "difference": "difference, relative", "z": "Z of each 3 x 3 bin"}
    page.row([page.figure(folder / f"{name}.png", caption, 270) for name, caption in captions.items()])
    rows = [(r["name"], f"{r['pixels']:.0f}", f"{r['ratio']['value']:.4f}",
             f"{r['ratio']['low']:.4f} to {r['ratio']['high']:.4f}") for r in report["regions"]]
    page.table(("region", "pixels", "mean, ours / Cycles", "95 % interval"), rows)
    bins, cost, speed = report["bins"], report["cost"], report["speed_at_equal_error"]
    page.add(f"<p>{bins['accepted']} of {bins['bins']} bins of 3 x 3 pixels accepted by the Z-test. One seed took "
             f"{cost['ours']['wall_s']:.2f} s here and {cost['cycles']['wall_s']:.2f} s in Cycles; at equal error "
             f"Cycles takes {speed['wall']:.2f} times as long. "
             "The full report is <code>validation/index.html</code> in the same folder.</p>")
    for reason in report["reasons"]:
        page.add(f"<p>{html.escape(reason)}</p>")


def add_costs(page, seconds_in_all):
    page.heading("5. What it cost")
    rows = []
    for line in (page.out / "costs.tsv").read_text(encoding="utf-8").splitlines():
        name, seconds, command = line.split("\t")
        rows.append((name, f"{float(seconds):.1f} s", command))
    page.table(("step", "time", "command"), rows + [("in all, with installing and building", f"{seconds_in_all} s", "")])


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    page = Page(Path(sys.argv[1]))
    page.add("<h1>OpenHumanBRDF: the main job on one person</h1>")
    page.add("<p>A scanned human, from its mesh and picture to a finished sample: regions, six material maps, "
             "relit views, and the proof against Blender Cycles.</p>")
    views = page.out / "samples" / "previews"
    page.row([page.figure(p, p.name.split(".relit.")[1][:-4], 360) for p in sorted(views.glob("view_000.relit.*.png"))])
    add_regions(page)
    add_maps(page)
    add_samples(page)
    add_validation(page)
    add_costs(page, sys.argv[2])
    inspect = page.out / "inspect.txt"
    if inspect.exists():
        page.heading("The scan, inspected")
        page.add(f"<pre>{html.escape(inspect.read_text(encoding='utf-8'))}</pre>")
    page.write("OpenHumanBRDF demo")


if __name__ == "__main__":
    main()
