"""Ground-truth maps relit in Blender against the sample they came from (docs/blender.md, "Round trip").

    blender -b -noaudio --factory-startup --python-exit-code 1 --python round_trip.py -- \\
        SAMPLE.exr ENVIRONMENT.exr... [--spp N] [--jump CM] [--flat] [--least DB] -o FOLDER

Each environment is one that SAMPLE was rendered with. Writes FOLDER/<light>.png (sample, Blender, difference times
8, side by side), maps/, and round_trip.json; prints a line a light. --flat leaves the relief out (depth 0) to show what
it is worth. Exits 1 if a masked PSNR is below --least.

PSNR: of sRGB-encoded radiance clipped to [0, 1], premultiplied by coverage, over the pixels whose mask is above 0.5
(masked), and over those of them that are covered wholly and whose neighbours differ by less than 1 cm in depth (inner).
"""
import argparse
import json
import math
import os
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.dirname(HERE))

import bpy  # noqa: E402
from support import ADDON  # noqa: E402

sys.path.insert(0, os.path.join(ADDON, "tools"))
import sample_to_maps  # noqa: E402

from human_material import compat  # noqa: E402
from human_material.services import (  # noqa: E402
    classes, decode, environment, grid, maps, material, relief, render)

EDGE_CM = 1.0
AMPLIFY = 8


def encoded(values):
    """sRGB of linear radiance, clipped."""
    return [decode.linear_to_srgb(min(max(v, 0.0), 1.0)) for v in values]


def psnr(a, b, pixels):
    error = sum((a[3 * p + c] - b[3 * p + c]) ** 2 for p in pixels for c in range(3)) / (3 * len(pixels))
    return -10 * math.log10(error) if error > 0 else math.inf


def mean_ratio(a, b, pixels):
    return sum(sum(a[3 * p:3 * p + 3]) for p in pixels) / sum(sum(b[3 * p:3 * p + 3]) for p in pixels)


def error_by_class(a, b, pixels, loaded):
    """Each class's share of the squared error, and of the pixels."""
    errors, area = [0.0] * 4, [0.0] * 4
    for p in pixels:
        error = sum((a[3 * p + c] - b[3 * p + c]) ** 2 for c in range(3))
        for k in range(4):
            errors[k] += loaded.shares[4 * p + k] * error
            area[k] += loaded.shares[4 * p + k]
    return {name: {"error": errors[k] / (sum(errors) or 1), "area": area[k] / sum(area)}
            for k, name in enumerate(classes.NAMES)}


def inner_pixels(loaded):
    """Wholly covered, away from depth edges."""
    width, height = loaded.size
    depth, mask = loaded.displacement_cm, loaded.mask
    return [p for p in range(width * height) if mask[p] > 0.999 and all(
        mask[q] > 0.999 and abs(depth[q] - depth[p]) < EDGE_CM for q in decode.neighbours(p, width, height))]


def scene_of(folder, options):
    scene = bpy.context.scene
    for item in list(scene.objects):
        bpy.data.objects.remove(item)
    item, loaded = relief.load_into(scene, folder, options.jump)
    if options.flat:
        for vertex in item.data.vertices:
            scale = loaded.info.camera.scale_at(100 * vertex.co.z)
            vertex.co = (vertex.co.x / scale, vertex.co.y / scale, 0)
    material.set_subsurface_scale(relief.material_of(item), 0)   # as samples are rendered so far
    render.prepare(scene, options.spp)
    render.set_pixel_exact(scene, relief.material_of(item), True)
    return scene, loaded


def write_picture(path, width, height, pictures):
    image = bpy.data.images.new("comparison", width * len(pictures), height)
    values = decode.zeros(4 * width * height * len(pictures))
    values[3::4] = decode.array("f", [1.0]) * (len(values) // 4)
    for i, picture in enumerate(pictures):
        for y in range(height):
            for c in range(3):
                begin = 4 * (y * width * len(pictures) + i * width) + c
                values[begin:begin + 4 * width:4] = decode.array("f", picture[3 * y * width + c:3 * (y + 1) * width:3])
    image.pixels.foreach_set(values)
    image.filepath_raw, image.file_format = path, "PNG"
    image.save()
    bpy.data.images.remove(image)


def compare(name, options, scene, loaded):
    width, height = loaded.size
    path = os.path.join(options.output, name + ".blender.exr")
    render.to_file(scene, path)
    found = maps.read_raster(path, 3, width, height)
    wanted = maps.read_raster(os.path.join(options.output, "maps", "relit.%s.exr" % name), 3, width, height)
    a, b = encoded(found), encoded(wanted)
    masked = [p for p in range(width * height) if loaded.mask[p] > 0.5]
    inner = inner_pixels(loaded)
    difference = [min(1.0, AMPLIFY * abs(u - v)) for u, v in zip(a, b)]
    write_picture(os.path.join(options.output, name + ".png"), width, height, (b, a, difference))
    return {"light": name, "masked_db": psnr(a, b, masked), "inner_db": psnr(a, b, inner),
            "full_frame_db": psnr(a, b, range(width * height)), "mean_ratio": mean_ratio(found, wanted, masked),
            "by_class": error_by_class(a, b, masked, loaded), "masked_pixels": len(masked), "inner_pixels": len(inner)}


def main(arguments):
    parser = argparse.ArgumentParser(prog="round_trip")
    parser.add_argument("sample")
    parser.add_argument("environments", nargs="+")
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--jump", type=float, default=grid.DEFAULT_JUMP_CM)
    parser.add_argument("--flat", action="store_true")
    parser.add_argument("--least", type=float, default=0)
    parser.add_argument("-o", "--output", required=True)
    options = parser.parse_args(arguments)
    sample_to_maps.convert(options.sample, os.path.join(options.output, "maps"), lights=True)
    scene, loaded = scene_of(os.path.join(options.output, "maps"), options)
    rows = []
    for path in options.environments:
        environment.set_environment(scene, path)
        environment.show_background(scene, False)
        rows.append(compare(os.path.splitext(os.path.basename(path))[0], options, scene, loaded))
        print("round trip %(light)s: %(masked_db).2f dB masked, %(inner_db).2f dB inner, mean x %(mean_ratio).4f"
              % rows[-1], flush=True)
    with open(os.path.join(options.output, "round_trip.json"), "w", encoding="utf-8") as file:
        json.dump({"blender": bpy.app.version_string, "principled": compat.generation(), "spp": options.spp,
                   "jump_cm": options.jump, "rows": rows}, file, indent=2)
    return min(row["masked_db"] for row in rows) < options.least


if __name__ == "__main__":
    begin = sys.argv.index("--") + 1 if "--" in sys.argv else 1
    sys.exit(int(main(sys.argv[begin:])))
