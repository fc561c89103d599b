# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes maps.json for a folder of map images that came from elsewhere.

    python3 write_maps_json.py FOLDER --perspective DISTANCE_CM HALF_WIDTH | --orthographic WIDTH_CM
        [--center-y CM] [--r CM] [--specular srgb_f0|disney08|linear_f0]

Files are found by the last word of their names: portrait_normal.png, N.exr, albedo.png, ... (see NAMES). PNG normals
are taken as (n + 1) / 2, PNG displacement as 0.5 + d / (2 r), PNG albedo as sRGB; EXR as signed, cm and linear.
Exits 2 with one line that names what is missing or ambiguous.
"""
import argparse
import os
import re
import sys

sys.dont_write_bytecode = True  # the folder may be an installed one
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from human_material.services import image_header, maps_json  # noqa: E402
from human_material.services.errors import InputError  # noqa: E402

NAMES = {
    "mask": ("mask", "matte", "alpha", "coverage"),
    "normal": ("normal", "normals", "nrm", "n"),
    "diffuse": ("diffuse", "albedo", "basecolor", "d"),
    "roughness": ("roughness", "rough", "r"),
    "specular": ("specular", "spec", "s"),
    "sss": ("sss", "subsurface"),
    "displacement": ("displacement", "disp", "depth", "height"),
    "classes": ("classes",),
}
ENCODINGS = {   # map -> (PNG, EXR)
    "mask": ("coverage", "coverage"), "normal": ("offset", "signed"), "diffuse": ("srgb", "linear"),
    "roughness": ("value", "value"), "sss": ("value", "value"), "displacement": ("offset", "signed_cm"),
    "classes": ("shares", "shares"),
}


def find_maps(folder):
    """map -> file name; InputError where two files fit."""
    found = {}
    for file in sorted(os.listdir(folder)):
        stem, extension = os.path.splitext(file.lower())
        if extension not in (".png", ".exr"):
            continue
        word = re.split(r"[^a-z]+", stem.rstrip("0123456789_-. "))[-1]
        for name, words in NAMES.items():
            if word in words:
                if name in found:
                    raise InputError(folder, name, "both %s and %s may be it" % (found[name], file),
                                     "leave one in the folder")
                found[name] = file
    missing = [name for name, (_, _, needed) in maps_json.MAPS.items() if needed and name not in found]
    if missing:
        raise InputError(folder, "", "has no file for " + ", ".join(missing),
                         "name the files after their maps, like portrait_normal.png")
    return found


def describe(folder, camera, r_cm=None, specular="srgb_f0"):
    """The content of maps.json."""
    entries, size = {}, None
    for name, file in find_maps(folder).items():
        header = image_header.read_header(os.path.join(folder, file))
        size = size or (header.width_px, header.height_px)
        encoding = specular if name == "specular" else ENCODINGS[name][header.kind == "EXR"]
        entries[name] = {"file": file, "encoding": encoding}
        if (name, encoding) == ("displacement", "offset"):
            entries[name]["r_cm"] = r_cm or camera.frame_width_cm / 2
    return maps_json.document(size, camera, entries)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder")
    kind = parser.add_mutually_exclusive_group(required=True)
    kind.add_argument("--perspective", nargs=2, type=float, metavar=("DISTANCE_CM", "HALF_WIDTH"))
    kind.add_argument("--orthographic", type=float, metavar="WIDTH_CM")
    parser.add_argument("--center-y", type=float, default=0.0, help="height of the frame's middle, cm")
    parser.add_argument("--r", type=float, help="r of 0.5 + d / (2 r) in cm; half the frame's width if not given")
    parser.add_argument("--specular", choices=tuple(maps_json.MAPS["specular"][1]), default="srgb_f0")
    options = parser.parse_args()
    try:
        if options.perspective:
            camera = maps_json.Camera("perspective", *options.perspective, center_y_cm=options.center_y)
        else:
            camera = maps_json.Camera("orthographic", width_cm=options.orthographic, center_y_cm=options.center_y)
        path = maps_json.write(options.folder, describe(options.folder, camera, options.r, options.specular))
        maps_json.read(path)
    except (InputError, OSError) as error:
        print("write_maps_json: %s" % error, file=sys.stderr)
        return 2
    print(path)
    return 0


if __name__ == "__main__":
    sys.exit(main())
