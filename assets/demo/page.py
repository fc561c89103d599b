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
from collections import defaultdict
from pathlib import Path

# As in the previews that `label` writes.
CLASS_COLOURS = defaultdict(lambda: "#888888", skin="#edad8c", hair="#73401f", fabric="#4582c9", leather="#d94038")
MAPS = ("normal", "diffuse", "roughness", "specular", "sss", "displacement")
STYLE = """
body{font:16px/1.5 system-ui,sans-serif;max-width:1180px;margin:2rem auto;padding:0 1rem;color:#222;background:#fff}
h1{margin-bottom:.2rem} h2{margin-top:2.5rem;border-bottom:1px solid #ddd;padding-bottom:.3rem}
.row{display:flex;flex-wrap:wrap;gap:12px} figure{margin:0} figcaption{font-size:.85rem;color:#555;text-align:center}
img{display:block;max-width:100%;background:repeating-conic-gradient(#eee 0 25%,#fff 0 50%) 0 0/16px 16px}
table{border-collapse:collapse} td,th{padding:.25rem .8rem;text-align:right;border-bottom:1px solid #eee}
td:first-child,th:first-child{text-align:left} .chip{display:inline-block;width:.9em;height:.9em;margin-right:.5em;border:1px solid #888}
pre{background:#f6f6f6;padding:1rem;overflow:auto;font-size:.8rem}
"""


class Markup(str):
    """HTML that is not to be escaped."""


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

    def link(self, path, words=""):
        """To a file or folder that ./demo left in OUT."""
        return f'<a href="{path}"><code>{html.escape(words or path)}</code></a>'

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
        """Cells are text; what comes as Markup is HTML already."""
        def line(cells, tag):
            return "<tr>" + "".join(f"<{tag}>{c if isinstance(c, Markup) else html.escape(str(c))}</{tag}>"
                                    for c in cells) + "</tr>"
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
    page.heading("1. Regions", "Each face of the scan belongs to one class of material. The picture shows them in the layout of "
                 f"the scan's own picture. Files: {page.link('regions/report.txt')}, {page.link('regions/faces.txt')}.")
    rows = [(Markup(f'<span class="chip" style="background:{CLASS_COLOURS[name]}"></span>{html.escape(name)}'),
             f"{c['faces']:,}", f"{100 * c['area_share']:.1f} %") for name, c in report["classes"].items()]
    page.table(("class", "faces", "area"), rows)
    pictures = sorted((page.out / "regions" / "maps").glob("**/*.png"))
    coloured = [p for p in pictures if "preview" in p.name or "preview" in p.parent.name] or pictures
    page.row([page.figure(p, p.stem, 300) for p in coloured[:4]])


def add_maps(page):
    page.heading("2. UV maps", "Baked from the scan's picture, its surface and the material table; "
                 f"as half and float EXR in {page.link('model/maps')}, shown here as their previews. The mesh beside them: "
                 f"{page.link('model/mesh.obj')}.")
    for previews in sorted((page.out / "model" / "maps").glob("*/previews"))[:2]:
        found = [previews / f"{name}.png" for name in ("albedo", "normal", "roughness", "specular", "sss", "displacement")]
        page.row([page.figure(p, f"{previews.parent.name}: {p.stem}", 180) for p in found if p.exists()])


def add_samples(page):
    samples = page.out / "samples"
    report = read_json(samples / "render.json")
    previews = samples / "previews"
    page.heading("3. Samples", "Each view is one multi-part EXR: mask, image-space maps and one part a light "
                 f"({page.link('samples/view_000.exr')}; how it was rendered: {page.link('samples/render.json')}). Frontal view:")
    page.row([page.figure(previews / f"view_000.{name}.png", name, 180) for name in ("mask",) + MAPS])
    lights = sorted({p.name.split(".relit.")[1][:-4] for p in previews.glob("view_000.relit.*.png")})
    for light in lights:
        page.add(f"<h3>Relit: {html.escape(light)}</h3>")
        pictures = sorted(previews.glob(f"view_*.relit.{light}.png"))
        page.row([page.figure(p, p.name.split(".")[0].replace("_", " "), 135) for p in pictures])
    seconds = sum(v["lights_s"] for v in report["views"])
    paths = sum(v["paths"] for v in report["views"])
    rays = sum(v["closest_hit_rays"] + v["shadow_rays"] + v["walk_segments"] for v in report["views"])
    if seconds > 0:
        page.add(f"<p>{len(report['views'])} views, {len(lights)} lights from one pass: {seconds:.1f} s, "
                 f"{paths / seconds / 1e6:.2f} million paths/s, {rays / seconds / 1e6:.2f} million rays/s.</p>")


def add_validation(page):
    folder = page.out / "validation"
    report = read_json(folder / "validate.json")
    words, colour = {
        "pass": ("Equal.", "#1a7f37"), "difference": ("Different.", "#b3261e"),
        "undecided": ("No difference found, and too noisy to be sure: more samples would tell.", "#a86500"),
    }.get(report["verdict"], (report["verdict"], "#222"))
    settings = report["settings"]
    page.heading("4. Equal to Cycles?", f'<b style="color:{colour}">{html.escape(words)}</b> '
                 f"The same view in Blender {report['blender']} and here, {settings['seeds']} seeds of {settings['spp']} "
                 "paths a pixel on each side.")
    captions = {"ours": "ours", "cycles": "Cycles", "difference": "difference, relative", "z": "Z of each 3 x 3 bin"}
    page.row([page.figure(folder / f"{name}.png", caption, 270) for name, caption in captions.items()])
    rows = [(r["name"], f"{r['pixels']:.0f}", f"{r['ratio']['value']:.4f}",
             f"{r['ratio']['low']:.4f} to {r['ratio']['high']:.4f}") for r in report["regions"]]
    page.table(("region", "pixels", "mean, ours / Cycles", "95 % interval"), rows)
    bins, cost, speed = report["bins"], report["cost"], report["speed_at_equal_error"]
    page.add(f"<p>{bins['accepted']} of {bins['bins']} bins of 3 x 3 pixels accepted by the Z-test. One seed took "
             f"{cost['ours']['wall_s']:.2f} s here and {cost['cycles']['wall_s']:.2f} s in Cycles; at equal error "
             f"Cycles takes {speed['wall']:.2f} times as long. "
             f"The full report: {page.link('validation/index.html')}.</p>")
    for reason in report["reasons"]:
        page.add(f"<p>{html.escape(reason)}</p>")


def add_chart(page):
    folder = page.out / "chart"
    report = read_json(folder / "chart.json")
    page.heading("5. Error against time", "The same view with 4, 16 and 64 paths a pixel, here and in Cycles "
                 "(<code>openhumanbrdf chart speed-accuracy</code>; times of this run, on this machine, which did nothing "
                 f"else if you let it). The figures: {page.link('chart/chart.csv')}.")
    page.row([page.figure(folder / "chart.svg", "error of one image against its time, loading included", 820)])
    for ratio in report["times_to_equal_error"]:
        page.add(f"<p>To an error of {100 * ratio['relative_error']:.2f} %: {html.escape(ratio['cycles'])} takes "
                 f"{ratio['cycles_over_ours']:.2f} times as long as {html.escape(ratio['ours'])} "
                 f"({ratio['cycles_over_ours_without_loading']:.2f} times without loading).</p>")


def loss_chart(records, width=620, height=240):
    """SVG of the loss against steps: each record as a dot, and the mean of the ten before it as a line."""
    steps, losses = [r["step"] for r in records], [r["loss"] for r in records]
    top = 1.05 * max(losses)

    def place(step, loss):
        return f"{50 + (width - 70) * step / steps[-1]:.1f},{height - 35 - (height - 55) * loss / top:.1f}"
    means = [sum(losses[max(0, i - 9):i + 1]) / len(losses[max(0, i - 9):i + 1]) for i in range(len(losses))]
    dots = "".join(f'<circle cx="{x}" cy="{y}" r="1.6" fill="#aac"/>' for x, y in
                   (place(s, v).split(",") for s, v in zip(steps, losses)))
    line = " ".join(place(s, v) for s, v in zip(steps, means))
    marks = "".join(f'<text x="44" y="{height - 31 - (height - 55) * v / top:.1f}" text-anchor="end">{v:.2f}</text>'
                    for v in (0, top / 2, top))
    return (f'<svg width="{width}" height="{height}" font-size="12" fill="#555" role="img" aria-label="loss against steps">'
            f'<line x1="50" y1="{height - 35}" x2="{width - 20}" y2="{height - 35}" stroke="#999"/>'
            f'<line x1="50" y1="15" x2="50" y2="{height - 35}" stroke="#999"/>{marks}{dots}'
            f'<polyline points="{line}" fill="none" stroke="#225" stroke-width="2"/>'
            f'<text x="{width - 20}" y="{height - 15}" text-anchor="end">step {steps[-1]}</text>'
            f'<text x="50" y="{height - 15}">loss of one step (dots), mean of ten log lines (line)</text></svg>')


def add_training(page):
    lines = [json.loads(line) for line in (page.out / "training" / "log.jsonl").read_text(encoding="utf-8").splitlines()]
    records = [line for line in lines if "loss" in line]
    first, last = records[:5], records[-5:]
    mean = lambda some: sum(r["loss"] for r in some) / len(some)
    page.heading("6. A short training", "The albedo prior learns from this person's own views, from nothing: enough to see "
                 "it learn, far from enough to be used. Loss (maps and rendering) "
                 f"{mean(first):.3f} over the first five log lines, {mean(last):.3f} over the last five.")
    page.add(loss_chart(records))


def add_estimate(page):
    estimate, previews = page.out / "estimate", page.out / "samples" / "previews"
    page.heading("7. From one picture", "The weights that come with the project never saw this person. From the picture on "
                 "the left they estimate its maps (upper row, 128 x 128 pixels); the truth is below. What they can and "
                 f"cannot do: {page.link('model_card.md')}. The maps, for Blender's add-on: {page.link('estimate/maps.json')}.")
    page.row([page.figure(estimate / "input.png", "input", 150)] +
             [page.figure(estimate / f"{name}.png", f"{name}, estimated", 150) for name in MAPS])
    page.row([page.figure(previews / "view_000.relit.studio.png", "the picture", 150)] +
             [page.figure(previews / f"view_000.{name}.png", f"{name}, true", 150) for name in MAPS])
    add_photograph(page)


def add_photograph(page):
    photograph = page.out / "photograph"
    page.add("<h3>As a photograph, without a mask</h3>")
    found = (photograph / "maps").exists()
    page.add("<p>The same person before a wall, on a floor, with a camera's noise. "
             + ("Nobody said where the person is: what differs from the picture's borders was taken "
                "(<code>--matting NETWORK</code> finds people before any background). "
                f"The maps: {page.link('photograph/maps/maps.json')}." if found else
                "<b>Nobody was found in it</b>: give <code>--matting NETWORK</code> or <code>--mask</code>.") + "</p>")
    pictures = [page.figure(photograph / "photograph.png", "the photograph", 150)]
    if found:
        pictures.append(page.figure(photograph / "maps" / "mask.png", "mask, found", 150))
        pictures += [page.figure(photograph / "maps" / f"{name}.png", f"{name}, estimated", 150) for name in MAPS]
    page.row(pictures)


def add_relit(page):
    page.heading("8. Relit and edited in Blender", "The estimate as a relief in Blender, under another environment (sunset); "
                 "then with what it takes for fabric made shiny leather, and made red.")
    captions = {"none": "relit", "fabric_shiny_leather": "fabric to shiny leather", "fabric_red": "red fabric"}
    page.row([page.figure(page.out / "relit" / f"{name}.png", caption, 360) for name, caption in captions.items()])


def add_production(page):
    folder = page.out / "production"
    page.heading("9. A dataset by one command", f"{page.link('production/plan.xml')} says who, which views and which lights; "
                 "<code>openhumanbrdf produce</code> makes it, and goes on where it was stopped. "
                 f"{page.link('production/page/index.html', 'The page to look through it')}, "
                 f"{page.link('production/page/CARD.md', 'its card')}, {page.link('production/dataset', 'its files')}.")
    width_px = 384 if (folder / "people").exists() else 128
    page.row([page.figure(folder / "page" / "contact_sheet.png", "everybody, first view", width_px)])
    realism = folder / "page" / "realism.png"
    if realism.exists():
        page.row([page.figure(realism, "as the scan came; with materials; with light under the skin; with the surface's detail",
                              1100)])


def add_costs(page, seconds_in_all):
    page.heading("10. What it cost")
    rows = []
    for line in (page.out / "costs.tsv").read_text(encoding="utf-8").splitlines():
        name, seconds, command = line.split("\t")
        rows.append((name, f"{float(seconds):.1f} s", command))
    page.table(("step", "time", "command"), rows + [("in all, with installing and building", f"{seconds_in_all} s", "")])


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    page = Page(Path(sys.argv[1]))
    card = Path(__file__).resolve().parent.parent / "weights" / "model_card.md"
    shutil.copyfile(card, page.out / "model_card.md")
    page.add("<h1>OpenHumanBRDF: the main job on one person</h1>")
    page.add("<p>A scanned human, from its mesh and picture to a finished sample: regions, material maps, "
             "relit views, and a comparison with Blender Cycles; and back, "
             "from one picture to estimated maps, relit and edited in Blender.</p>")
    views = page.out / "samples" / "previews"
    page.row([page.figure(p, p.name.split(".relit.")[1][:-4], 360) for p in sorted(views.glob("view_000.relit.*.png"))])
    add_regions(page)
    add_maps(page)
    add_samples(page)
    add_validation(page)
    add_chart(page)
    add_training(page)
    add_estimate(page)
    add_relit(page)
    add_production(page)
    add_costs(page, sys.argv[2])
    inspect = page.out / "inspect.txt"
    if inspect.exists():
        page.heading("The scan, inspected")
        page.add(f"<pre>{html.escape(inspect.read_text(encoding='utf-8'))}</pre>")
    page.write("OpenHumanBRDF demo")


if __name__ == "__main__":
    main()
