# SPDX-License-Identifier: GPL-3.0-or-later
"""Point lights in this project's units: position in cm in our axes, radiant intensity with distances in metres."""
import math

import bpy

from . import grid
from .errors import InputError

NAME = "HM Point"


def to_blender(position_cm):
    """Our axes (Y up, cm) in Blender's (Z up, m)."""
    x, y, z = position_cm
    return x * grid.CM, -z * grid.CM, y * grid.CM


def add_point(scene, position_cm, intensity):
    """A light of no size whose irradiance at d metres is intensity / d^2."""
    light = bpy.data.lights.new(NAME, "POINT")
    light.energy = 4 * math.pi * intensity   # Blender: intensity = watts / 4 pi
    light.shadow_soft_size = 0
    light.color = (1, 1, 1)
    item = bpy.data.objects.new(NAME, light)
    item.location = to_blender(position_cm)
    scene.collection.objects.link(item)
    return item


def parse_point(text):
    """((x, y, z), intensity) of "x,y,z,I". Throws InputError."""
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if len(values) != 4 or not all(math.isfinite(v) for v in values) or values[3] < 0:
        raise InputError("", "--point " + text, "is not a point light",
                         "write x,y,z,I: cm, and the irradiance at 1 m, I >= 0")
    return tuple(values[:3]), values[3]
