# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a maps folder of a sample's ground truth: python3 sample_to_maps.py view_000.exr -o MAPS

Samples are multi-part EXRs, which Blender cannot read; this splits one with oiiotool (Debian: openimageio-tools) into
a file a map and writes maps.json (docs/maps_json.md). --lights also writes relit.<light>.exr beside them, to compare
with what Blender renders. Exits 2 with one line if the input is wrong.
"""
import argparse
import os
import re
import subprocess
import sys

sys.dont_write_bytecode = True  # the folder may be an installed one
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from human_material.services import classes, image_header, maps_json  # noqa: E402
from human_material.services.errors import InputError  # noqa: E402

#: map -> (channels of the part in the map's order, names in the file, encoding)
PARTS = {
    "mask": ("A", "Y", "coverage"),
    "normal": ("X,Y,Z", "R,G,B", "signed"),
    "diffuse": ("R,G,B", "R,G,B", "linear"),
    "roughness": ("Y", "Y", "value"),
    "specular": ("Y", "Y", "srgb_f0"),
    "sss": ("Y", "Y", "value"),
    "displacement": ("Y", "Y", "signed_cm"),
    "classes": (",".join(classes.NAMES[1:]), ",".join("RGBA"[:len(classes.NAMES) - 1]), "shares"),
}
LIGHT = "relit."


def oiiotool(*arguments):
    try:
        done = subprocess.run(["oiiotool", *arguments], capture_output=True, text=True)
    except FileNotFoundError:
        raise InputError("oiiotool", "", "is not installed", "apt install openimageio-tools") from None
    if done.returncode != 0:
        raise InputError(arguments[0], "", "oiiotool: " + (done.stderr or done.stdout).strip(),
                         "is this a sample that openhumanbrdf render wrote?")
    return done.stdout


def describe(sample):
    """(names of the parts, attributes ohb:* of the sample)."""
    text = oiiotool("--info", "-v", "-a", sample)
    attributes = dict(re.findall(r'^\s*(ohb:[^:\s]+): "?(.*?)"?$', text, re.MULTILINE))
    return re.findall(r'^\s*(?:oiio:subimagename|name): "?(.*?)"?$', text, re.MULTILINE), attributes


def extract(sample, part, channels, names, target):
    # A number of channels apart from RGB or Y makes some readers guess: channels are renamed.
    oiiotool(sample, "--subimage", part, "--ch", channels, "--chnames", names, "--compression", "zip", "-o", target)


def camera_of(attributes, sample):
    try:
        distance, half, center = (float(attributes["ohb:camera" + key])
                                  for key in ("Distance_cm", "HalfWidth", "CenterY_cm"))
    except (KeyError, ValueError):
        raise InputError(sample, "", "does not say its camera (ohb:camera...)",
                         "is this a sample that openhumanbrdf render wrote?") from None
    return maps_json.Camera("perspective", distance_cm=distance, half_width=half, center_y_cm=center)


def convert(sample, folder, lights=False):
    """Writes the maps folder. Returns the names of the lights that were written."""
    if not os.path.isfile(sample):
        raise InputError(sample, "", "there is no such file", "give a sample (view_000.exr)")
    parts, attributes = describe(sample)
    camera = camera_of(attributes, sample)
    os.makedirs(folder, exist_ok=True)
    entries = {}
    for name, (channels, names, encoding) in PARTS.items():
        extract(sample, name, channels, names, os.path.join(folder, name + ".exr"))
        entries[name] = {"file": name + ".exr", "encoding": encoding}
    header = image_header.read_header(os.path.join(folder, "mask.exr"))
    source = {"program": "sample_to_maps.py", "sample": os.path.basename(sample),
              **{key[4:]: attributes[key] for key in ("ohb:human", "ohb:view", "ohb:viewCount") if key in attributes}}
    written = [part for part in dict.fromkeys(parts) if part.startswith(LIGHT)] if lights else []
    for part in written:
        extract(sample, part, "R,G,B", "R,G,B", os.path.join(folder, part + ".exr"))
    maps_json.write(folder, maps_json.document((header.width_px, header.height_px), camera, entries, source))
    return [part[len(LIGHT):] for part in written]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sample")
    parser.add_argument("--lights", action="store_true", help="also write the relit pictures")
    parser.add_argument("-o", "--output", required=True, help="maps folder")
    options = parser.parse_args()
    try:
        convert(options.sample, options.output, options.lights)
    except (InputError, OSError) as error:
        print("sample_to_maps: %s" % error, file=sys.stderr)
        return 2
    print(os.path.join(options.output, maps_json.FILE_NAME))
    return 0


if __name__ == "__main__":
    sys.exit(main())
