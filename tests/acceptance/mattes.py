#!/usr/bin/env python3
"""How true mattes are: people of a dataset rendered, put before pieces of photographs, and found again by `estimate`.

usage: mattes.py DATASET PHOTOS NETWORK.onnx OUT [COUNT]

DATASET is what `openhumanbrdf produce` wrote (humans/NAME/model); PHOTOS holds the photographs that PLACES names; COUNT (40)
pictures, two views a person. Prints one line a picture and their means: intersection over union of the masks above one half,
and the sum of absolute differences in thousands of pixels (SAD) and in percent of the person. Needs oiiotool (package
openimageio-tools) and numpy. Programs are those of build/release/bin, or $OPENHUMANBRDF and $HUMANMATERIAL.
Exits with 1 where the mean is below what is asked, 0.97. What is there in OUT already is not rendered again.
"""
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
PLACES = (("pexels_women_on_phones.jpg", "390x1056+410+0"),     # wood and meadow between the two women
          ("yogait_side_lunge_left.jpg", "320x720+0+0"),        # an office: table and chairs
          ("yogait_side_lunge_left.jpg", "330x720+750+0"))      # sofa
CANVAS, PERSON_PX, LEFT, TOP = (480, 640), 384, 48, 216         # width, height; where the square of the render is
ASKED_IOU = 0.97


def program(name):
    return os.environ.get(name.upper(), ROOT / "build/release/bin" / name)


def run(*words):
    result = subprocess.run([str(word) for word in words], capture_output=True, text=True)
    if result.returncode != 0:
        sys.exit(f"{words[0]} {words[1]}: {result.stderr[-500:]}")
    return result.stdout


def pixels(file, *actions, channels="R,G,B"):
    """Rows of floats in [0, 1], by way of an 8-bit pnm."""
    plain = file.with_suffix(".tmp.ppm" if channels == "R,G,B" else ".tmp.pgm")
    run("oiiotool", file, *actions, "--ch", channels, "-d", "uint8", "-o", plain)
    data = plain.read_bytes()
    plain.unlink()
    kind, width, height, most = data.split(maxsplit=4)[:4]
    depth = 3 if kind == b"P6" else 1
    count = int(width) * int(height) * depth
    return np.frombuffer(data[-count:], np.uint8).reshape(int(height), int(width), depth) / int(most)


def write_picture(file, rows):
    plain = file.with_suffix(".tmp.ppm")
    plain.write_bytes(b"P6 %d %d 255\n" % rows.shape[1::-1] + np.round(rows * 255).astype(np.uint8).tobytes())
    run("oiiotool", plain, "-o", file)
    plain.unlink()


def linear(x):
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)


def encoded(x):
    x = np.clip(x, 0, 1)
    return np.where(x <= 0.0031308, x * 12.92, 1.055 * x ** (1 / 2.4) - 0.055)


def background(photos, number, out):
    """A piece of a photograph that covers the canvas, every other one exchanged left and right."""
    name, box = PLACES[number % len(PLACES)]
    piece = out / f"place_{number % len(PLACES)}.png"
    if not piece.exists():
        width, height = (int(v) for v in box.split("+")[0].split("x"))
        scale = max(CANVAS[0] / width, CANVAS[1] / height)
        size = f"{round(width * scale)}x{round(height * scale)}"
        run("oiiotool", photos / name, "--cut", box, "--resize", size, "--cut", f"{CANVAS[0]}x{CANVAS[1]}+0+0", "-o", piece)
    rows = pixels(piece)
    return rows[:, ::-1] if number % 2 else rows


def composite(previews, view, place, file):
    """The rendered view before a place; returns the true mask, of the canvas's size."""
    picture = next(previews.glob(f"view_{view:03d}.relit.*.png"))
    square = (slice(TOP, TOP + PERSON_PX), slice(LEFT, LEFT + PERSON_PX))
    mask = np.zeros((CANVAS[1], CANVAS[0], 1))
    mask[square] = pixels(previews / f"view_{view:03d}.mask.png", channels="0")
    foreground = np.zeros((CANVAS[1], CANVAS[0], 3))
    foreground[square] = linear(pixels(picture))
    write_picture(file, encoded(foreground + (1 - mask) * linear(place)))
    return mask[..., 0]


def found_mask(maps):
    """mask.png of a folder of maps, back on the canvas."""
    rows = pixels(maps / "mask.png", channels="0")[..., 0]
    crop = json.loads((maps / "maps.json").read_text())["source"]["photo_crop_px"]
    scale = rows.shape[0] / crop["side"]
    x = (np.arange(CANVAS[0]) + 0.5 - crop["left"]) * scale - 0.5
    y = (np.arange(CANVAS[1]) + 0.5 - crop["top"]) * scale - 0.5
    lines = np.array([np.interp(x, np.arange(rows.shape[1]), row, left=0, right=0) for row in rows])
    return np.array([np.interp(y, np.arange(rows.shape[0]), column, left=0, right=0) for column in lines.T]).T


def main():
    if len(sys.argv) not in (5, 6):
        sys.exit(__doc__)
    dataset, photos, network, out = (Path(word) for word in sys.argv[1:5])
    count = int(sys.argv[5]) if len(sys.argv) == 6 else 40
    out.mkdir(parents=True, exist_ok=True)
    people = sorted((dataset / "humans").iterdir())[:(count + 1) // 2]
    weights = sorted((ROOT / "assets/weights").glob("*.safetensors"))
    scores = []
    for number in range(count):
        person, view = people[number // 2], number % 2
        renders = out / f"render_{person.name}"
        if not (renders / "view_001.exr").exists():
            run(program("openhumanbrdf"), "render", person / "model", "--environment", ROOT / "assets/environments/overcast_street.exr",
                "--views", 2, "--size", PERSON_PX, "--spp", 12, "--overwrite", "-o", renders)
        picture, maps = out / f"{number:02d}.png", out / f"maps_{number:02d}"
        truth = composite(renders / "previews", view, background(photos, number, out), picture)
        run(program("humanmaterial"), "estimate", picture, "--matting", network, "--weights", *weights, "--size", PERSON_PX, "-o", maps)
        found = found_mask(maps)
        both, either = (found > 0.5) & (truth > 0.5), (found > 0.5) | (truth > 0.5)
        sad = np.abs(found - truth).sum()
        scores.append((both.sum() / either.sum(), sad / 1000, 100 * sad / truth.sum()))
        print(f"{number:02d} {person.name} view {view}: IoU {scores[-1][0]:.4f}, SAD {scores[-1][1]:.2f} "
              f"({scores[-1][2]:.1f} % of the person)", flush=True)
    mean, worst = np.mean(scores, axis=0), min(score[0] for score in scores)
    print(f"{count} pictures: IoU {mean[0]:.4f} (worst {worst:.4f}), SAD {mean[1]:.2f} ({mean[2]:.1f} % of the person)")
    return 0 if mean[0] >= ASKED_IOU else 1


if __name__ == "__main__":
    sys.exit(main())
