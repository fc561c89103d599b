# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets of edits (data/presets.json), and what is written after --edit. No bpy."""
import json
import os
import re
from dataclasses import dataclass

from . import classes, decode
from .errors import InputError

_FILE = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "data", "presets.json")


@dataclass(frozen=True)
class Preset:
    """None: left as it is."""
    name: str
    label: str
    color: tuple = None      # linear Rec. 709
    roughness: float = None
    f0: float = None
    sss: float = None
    classes: tuple = ()      # whose menu lists it



def color_of(text):
    """Linear colour of #rrggbb (sRGB). Throws InputError."""
    if not re.fullmatch(r"#[0-9a-fA-F]{6}", text):
        raise InputError("", "colour '%s'" % text, "is not #rrggbb", "write six hexadecimal digits, sRGB")
    return tuple(decode.srgb_to_linear(int(text[i:i + 2], 16) / 255) for i in (1, 3, 5))


def _read():
    with open(_FILE, encoding="utf-8") as file:
        entries = json.load(file)["presets"]
    return {entry["name"]: Preset(
        entry["name"], entry["label"], color_of(entry["color"]) if "color" in entry else None,
        entry.get("roughness"),
        decode.srgb_to_linear(entry["specular"]) if "specular" in entry else None,
        entry.get("sss"), tuple(entry["classes"])) for entry in entries}


PRESETS = _read()


def of_class(class_name):
    """The presets that make sense for a class."""
    return [preset for preset in PRESETS.values() if class_name in preset.classes]


def parse_edit(text):
    """(class name, Preset) of CLASS:PRESET or CLASS:#rrggbb. Throws InputError."""
    class_name, _, what = text.partition(":")
    if class_name not in classes.NAMES:
        raise InputError("", "--edit " + text, "names no class", "write CLASS:PRESET with CLASS one of "
                         + ", ".join(classes.NAMES))
    if what.startswith("#"):
        return class_name, Preset(what, what, color=color_of(what))
    if what not in PRESETS:
        raise InputError("", "--edit " + text, "names no preset", "write #rrggbb or one of "
                         + ", ".join(PRESETS))
    return class_name, PRESETS[what]
