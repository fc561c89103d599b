# SPDX-License-Identifier: GPL-3.0-or-later
"""Relights and edits the person of a maps folder, without a window. What `humanmaterial relight` runs.

    blender -b -noaudio --factory-startup [-t THREADS] --python-exit-code 1 --python relight.py -- \\
        MAPS [--environment E.exr] [--rotation DEG] [--strength S] [--point x,y,z,I]... [--edit CLASS:PRESET]... \\
        [--size PX] [--spp N] [--seed N] [--background transparent|environment] [--subsurface-scale F] \\
        [--subsurface random_walk_skin|random_walk_fixed|burley] [--jump CM] [--report FILE] -o PICTURE

MAPS            maps folder, or its maps.json (docs/maps_json.md)
--environment   latitude-longitude picture, linear EXR or HDR; without it, lights are those of --point
--rotation      degrees by which the environment turns about +Y, right-handed: light from the viewer (+Z) comes from
                the picture's right (+X) after 90
--strength      factor on the environment, default 1
--point         point light: position in cm (our axes) and irradiance at 1 m; may be repeated
--edit          CLASS is a name of data/materials.json; PRESET a name of data/presets.json or #rrggbb (sRGB), a new
                mean colour; may be repeated, later ones win
--size          width of the picture in pixels; at that of the maps, the default, each pixel of the picture is one of
                the maps, at others they are interpolated
--spp           samples a pixel, default 64
--background    behind the person: transparent (default) or the environment
--subsurface-scale  factor on the subsurface map, default 1; 0 renders as samples are rendered so far
--subsurface    method, by what it does in every Blender; default random_walk_skin, which has the least noise
--jump          depth difference of neighbouring pixels in cm above which the surface is cut, default 5
--report        JSON: output, size_px, seconds {load, render}, blender, principled, warnings
-o              .png (16-bit sRGB, straight alpha) or .exr (linear float, premultiplied alpha); written whole or not
                at all

Exit codes: 0 done; 2 bad input or usage, one line on stderr that starts with "relight: "; 75 the disk is full; 70 a
bug, with a traceback on stderr. Blender's own messages go to stdout.
"""
import argparse
import errno
import json
import os
import shutil
import sys
import time
import traceback

import bpy

sys.dont_write_bytecode = True  # the folder may be an installed one
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from human_material import compat  # noqa: E402
from human_material.services import (  # noqa: E402
    edit, environment, lights, material, presets, relief, render)
from human_material.services.errors import InputError  # noqa: E402

DONE, BAD_INPUT, BUG, TRY_AGAIN = 0, 2, 70, 75
FULL_DISK_BYTES = 1 << 20


def parse(arguments):
    parser = argparse.ArgumentParser(prog="relight", allow_abbrev=False)
    parser.add_argument("maps", metavar="MAPS")
    parser.add_argument("--environment")
    parser.add_argument("--rotation", type=number, default=0.0)
    parser.add_argument("--strength", type=number, default=1.0)
    parser.add_argument("--point", action="append", default=[])
    parser.add_argument("--edit", action="append", default=[])
    parser.add_argument("--size", type=whole(1, 16384))
    parser.add_argument("--spp", type=whole(1, 1 << 20), default=64)
    parser.add_argument("--seed", type=whole(0, (1 << 31) - 1), default=0)
    parser.add_argument("--background", choices=("transparent", "environment"), default="transparent")
    parser.add_argument("--subsurface", choices=tuple(compat.SUBSURFACE_METHODS), default="random_walk_skin")
    parser.add_argument("--subsurface-scale", type=number, default=1.0)
    parser.add_argument("--jump", type=number, default=5.0)
    parser.add_argument("--report")
    parser.add_argument("-o", "--output", required=True)
    return parser.parse_args(arguments)


def number(text):
    value = float(text)
    if not abs(value) <= 1e9:
        raise ValueError(text)
    return value


def whole(low, high):
    def whole_number(text):
        value = int(text)
        if not low <= value <= high:
            raise argparse.ArgumentTypeError("not from %d to %d" % (low, high))
        return value
    return whole_number


def check(options):
    """What can be refused before the maps are loaded."""
    edits = [presets.parse_edit(text) for text in options.edit]
    points = [lights.parse_point(text) for text in options.point]
    if not options.environment and not points:
        raise InputError("", "relight", "there is no light", "give --environment E.exr or --point x,y,z,I")
    if options.strength < 0 or options.subsurface_scale < 0 or options.jump <= 0:
        raise InputError("", "relight", "--strength, --subsurface-scale or --jump is negative",
                         "give numbers above 0")
    render.check_target(options.output)
    return edits, points


def relight(options):
    start = time.monotonic()
    edits, points = check(options)
    scene = bpy.context.scene
    for item in list(scene.objects):   # the factory's cube, light and camera
        bpy.data.objects.remove(item)
    item, loaded = relief.load_into(scene, options.maps, options.jump,
                                    subsurface_method=options.subsurface)
    skin = relief.material_of(item)
    material.set_subsurface_scale(skin, options.subsurface_scale)
    for class_name, preset in edits:
        try:
            edit.expect_present(skin, class_name)
        except InputError as error:   # a picture is asked for all the same
            loaded.warnings.append(str(error))
        edit.apply(skin, class_name, preset)
    if options.environment:
        environment.set_environment(scene, options.environment, options.rotation, options.strength)
    else:
        environment.set_dark(scene)
    for position_cm, intensity in points:
        lights.add_point(scene, position_cm, intensity)
    environment.show_background(scene, options.background == "environment")
    render.prepare(scene, options.spp, options.seed)
    set_size(scene, options.size)
    material.set_visible_scattering(skin, loaded.info.camera.frame_width_cm / scene.render.resolution_x)
    render.set_pixel_exact(scene, skin, scene.render.resolution_x == loaded.info.width_px)
    loaded_at = time.monotonic()
    render.to_file(scene, options.output)
    return {"output": os.path.abspath(options.output),
            "size_px": [scene.render.resolution_x, scene.render.resolution_y],
            "seconds": {"load": round(loaded_at - start, 3), "render": round(time.monotonic() - loaded_at, 3)},
            "blender": bpy.app.version_string, "principled": compat.generation(), "warnings": loaded.warnings}


def set_size(scene, width_px):
    if width_px:
        settings = scene.render
        settings.resolution_y = max(1, round(settings.resolution_y * width_px / settings.resolution_x))
        settings.resolution_x = width_px


def say(text):
    print("relight: " + text, file=sys.stderr, flush=True)


def main(arguments):
    options = parse(arguments)
    try:
        result = relight(options)
        if options.report:
            with open(options.report, "w", encoding="utf-8") as file:
                json.dump(result, file, indent=2)
    except InputError as error:
        say(str(error))
        return BAD_INPUT
    except (OSError, RuntimeError) as error:
        if getattr(error, "errno", None) == errno.ENOSPC or disk_is_full(options.output):
            say("%s: the disk is full; free some space and try again" % options.output)
            return TRY_AGAIN
        if isinstance(error, OSError):
            say(str(error))
            return BAD_INPUT
        traceback.print_exc()
        return BUG
    except Exception:   # noqa: BLE001  the last line of defence: a bug has its own exit code
        traceback.print_exc()
        return BUG
    for warning in result["warnings"]:
        say("warning: " + warning)
    return DONE


def disk_is_full(path):
    folder = os.path.dirname(os.path.abspath(path))
    return os.path.isdir(folder) and shutil.disk_usage(folder).free < FULL_DISK_BYTES


def own_arguments():
    """Those after "--"; all of them where bpy is a module of Python and not a program."""
    if "--" in sys.argv:
        return sys.argv[sys.argv.index("--") + 1:]
    return [] if bpy.app.binary_path else sys.argv[1:]


if __name__ == "__main__":
    sys.exit(main(own_arguments()))
