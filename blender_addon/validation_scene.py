# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds a scene that `openhumanbrdf validate` wrote and renders it in Cycles, once for each seed.

    blender -b -noaudio --factory-startup -t N --python-exit-code 1 --python validation_scene.py -- scene.json N
    VENV/bin/python validation_scene.py -- scene.json N      (with the module bpy in place of Blender)

N: threads, 0 for all.
Input: scene.json and the raw little-endian arrays and images that it names, beside it (see
renderer/validation/cycles_scene.h). Lengths are metres, axes are Blender's.
Output, in the folder `output` of scene.json: pass_<i>_seed_<k>_box_<j>.exr (whole frame, float RGBA, linear
Rec. 709, premultiplied; 0 outside the box) and report.json (versions, every setting as asked for last and as read
back after the last render, times).
Prints `progress <done> <total>` lines. Exits 1 with a Python traceback if anything is wrong.

The scene's model says which Blender it is for: v1, 3.4 (Principled v1); v2, 4.5 (Principled v2). Each holds for
that version alone: names of sockets and of sampling patterns differ (see docs/commands/validate.md).
"""
import json
import os
import sys
import time

import bpy

sys.dont_write_bytecode = True  # the folder may be an installed one
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import validation_objects as objects  # noqa: E402
from validation_settings import IS_V2, Settings, set_cycles, set_later_options, set_output  # noqa: E402

FORMAT = "openhumanbrdf validation scene 1"
VERSIONS = {"v1": (3, 4), "v2": (4, 5)}


def clear_factory_scene():
    if IS_V2:
        bpy.ops.wm.read_factory_settings()   # the module has read the user's
    for kind in (bpy.data.objects, bpy.data.materials, bpy.data.meshes, bpy.data.lights, bpy.data.cameras,
                 bpy.data.worlds):
        for item in list(kind):
            kind.remove(item)


def build_scene(folder, description, threads):
    """The whole scene; returns the settings to read back."""
    clear_factory_scene()
    settings = Settings()
    scene = bpy.context.scene
    set_cycles(settings, scene, description)
    if IS_V2:
        set_later_options(settings, scene, threads)
    set_output(settings, scene, description["size_px"])
    mesh = objects.build_mesh(folder, description["mesh"])
    for texture_set in description["texture_sets"]:
        mesh.materials.append(objects.build_material(settings, folder, texture_set, description["sss_scale"]))
    objects.add_object(settings, mesh, description["turn"])
    objects.build_world(settings, folder, description["environment"])
    for number, point in enumerate(description["points"]):
        objects.add_point_light(settings, number, point)
    objects.add_camera(settings, description["camera"])
    return settings


def keep_scene(settings, path, work, size_px):
    """Writes the scene, ready to render the first image of the pass, as a .blend that holds its pictures and names no
    file of this machine."""
    scene = bpy.context.scene
    set_adaptive(settings, work["adaptive_threshold"])
    set_box(settings, None, size_px)
    scene.cycles.samples, scene.cycles.seed = work["spp"], work["seeds"][0]
    scene.render.filepath = "//"
    for image in bpy.data.images:
        if image.source == "FILE":
            image.pack()
            image.filepath_raw = "//" + os.path.basename(image.filepath)
            for packed in image.packed_files:
                packed.filepath = image.filepath_raw
    bpy.ops.wm.save_as_mainfile(filepath=path, check_existing=False, compress=True, copy=True, relative_remap=False)
    if not os.path.isfile(path):
        raise OSError("Blender did not write %s" % path)


# Rendering ----------------------------------------------------------------------------------------------

def timed(action):
    """Wall and processor seconds of the action."""
    wall, processor = time.perf_counter(), time.process_time()
    action()
    return time.perf_counter() - wall, time.process_time() - processor


def render_image(settings, spp, seed, path):
    scene = bpy.context.scene
    settings.set("scene.cycles", scene.cycles, "samples", spp)
    settings.set("scene.cycles", scene.cycles, "seed", seed)
    scene.render.filepath = path
    bpy.ops.render.render(write_still=True)


def warm_up(settings, path):
    """Loads meshes and images and builds the trees; persistent data keeps them for the seeds."""
    render_image(settings, 1, 1, path)
    os.remove(path)


def set_box(settings, box, size_px):
    """Renders only the pixels x0 <= x < x1, y0 <= y < y1 (row 0 at the top) of the frame; all if there is no box."""
    x0, y0, x1, y1 = box or (0, 0, size_px, size_px)
    render = bpy.context.scene.render
    inside = 0.01   # of a pixel: neither rounding nor cutting moves the edge
    settings.set_all("scene.render", render, {
        "use_border": box is not None, "use_crop_to_border": False,
        "border_min_x": (x0 + inside) / size_px, "border_max_x": min(1.0, (x1 + inside) / size_px),
        "border_min_y": (size_px - y1 + inside) / size_px,
        "border_max_y": min(1.0, (size_px - y0 + inside) / size_px)})


def set_adaptive(settings, threshold):
    """Stops pixels whose estimated noise is below the threshold; 0: never, as all that must be unbiased wants."""
    settings.set("scene.cycles", bpy.context.scene.cycles, "use_adaptive_sampling", threshold > 0)
    if threshold > 0:
        settings.set("scene.cycles", bpy.context.scene.cycles, "adaptive_threshold", threshold)


def render_seed(settings, spp, seed, boxes, size_px, output, name):
    """One image, of as many files as there are boxes."""
    row = {"seed": seed, "spp": spp, "files": [], "wall_s": 0.0, "cpu_s": 0.0}
    for number, box in enumerate(boxes or [None]):
        set_box(settings, box, size_px)
        file = "%s_box_%d.exr" % (name, number)
        wall, processor = timed(lambda: render_image(settings, spp, seed, os.path.join(output, file)))
        row["files"].append(file)
        row["wall_s"] += wall
        row["cpu_s"] += processor
    return row


def render_passes(settings, description, output):
    passes = []
    total = sum(len(work["seeds"]) for work in description["passes"])
    done = 0
    print("progress %d %d" % (done, total), flush=True)
    for number, work in enumerate(description["passes"]):
        rows = []
        set_adaptive(settings, work["adaptive_threshold"])
        for k, seed in enumerate(work["seeds"]):
            rows.append(render_seed(settings, work["spp"], seed, work["boxes"], description["size_px"], output,
                                    "pass_%d_seed_%d" % (number, k)))
            done += 1
            print("progress %d %d" % (done, total), flush=True)
        passes.append(rows)
    return passes


def check(path, description):
    if description["format"] != FORMAT:
        raise ValueError("%s: format '%s' is not '%s'" % (path, description["format"], FORMAT))
    if bpy.app.version[:2] != VERSIONS[description["model"]]:
        raise ValueError("%s: is for Blender %d.%d, this is %s" % (
            path, *VERSIONS[description["model"]], bpy.app.version_string))


def run(path, threads):
    folder = os.path.dirname(os.path.abspath(path))
    with open(path, encoding="utf-8") as file:
        description = json.load(file)
    check(path, description)
    output = os.path.join(folder, description["output"])
    os.makedirs(output, exist_ok=True)
    built = []
    build_s, _ = timed(lambda: built.append(build_scene(folder, description, threads)))
    settings = built[0]
    load_s, load_cpu_s = timed(lambda: warm_up(settings, os.path.join(output, "warm_up.exr")))
    if description["kept"]:
        keep_scene(settings, os.path.join(output, description["kept"]), description["passes"][0], description["size_px"])
    passes = render_passes(settings, description, output)
    report = {"versions": {"blender": bpy.app.version_string}, "build_s": build_s, "load_s": load_s,
              "load_cpu_s": load_cpu_s, "passes": passes, "settings": settings.read_back()}
    with open(os.path.join(output, "report.json"), "w", encoding="utf-8") as file:
        json.dump(report, file, indent=1)


if __name__ == "__main__":
    arguments = sys.argv[sys.argv.index("--") + 1:]
    run(arguments[0], int(arguments[1]))
    if getattr(bpy.app, "module", False):
        sys.stdout.flush()
        os._exit(0)   # some modules crash while Python ends, after the work
