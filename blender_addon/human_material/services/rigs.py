# SPDX-License-Identifier: GPL-3.0-or-later
"""Rigs of lights around a person: three-point, and the 36 + 1 point lights of the paper's loss, all at once or one a
frame. Distances are in heights of the person's frame, so that a head and a whole body are lit alike."""
import math
import random

import bpy
from mathutils import Vector

from . import camera, grid, lights
from .errors import InputError

RIG = "hm_rig"        # custom property of the lights: the rig that they belong to
NAME = "HM Rig"
#: name -> (degrees to the picture's right of the viewer, degrees up, irradiance at the person, size in frame widths)
THREE_POINT = {"Key": (-45, 35, 3.0, 0.5), "Fill": (50, 10, 1.0, 1.0), "Rim": (160, 40, 3.0, 0.3)}
AREA_AWAY = 1.6       # frame widths from the person
FIXED, INTENSITY, AWAY = 36, 5.5, 2.0   # as `humanmaterial` has them: at 5, 15, ..., 175 degrees, frames away


def remove(scene):
    """Takes the rig away. Gives how many lights that were."""
    mine = [item for item in scene.objects if RIG in item]
    for item in mine:
        data, action = item.data, item.animation_data.action if item.animation_data else None
        bpy.data.objects.remove(item)
        if data.users == 0:
            bpy.data.lights.remove(data)
        if action is not None and action.users == 0:
            bpy.data.actions.remove(action)
    return len(mine)


def frame_of(item):
    """(middle of the frame in the world, frame width in m) of a person."""
    return item.matrix_world.translation.copy(), camera.frame_width_cm(item[camera.PROPERTY]) * grid.CM


def _place(scene, item, name, direction, distance_m, data):
    """A light in a direction of the person's own axes (to the right, up, to the viewer), looking at its middle."""
    middle, _ = frame_of(item)
    light = bpy.data.objects.new("%s %s" % (NAME, name), data)
    turned = item.matrix_world.to_quaternion() @ Vector(direction).normalized()
    light.location = middle + turned * distance_m
    light.rotation_euler = turned.to_track_quat("Z", "Y").to_euler()
    light[RIG] = name
    scene.collection.objects.link(light)
    return light


def three_point(scene, item):
    """Key, fill and rim as areas. Replaces the rig that is there."""
    remove(scene)
    _, width = frame_of(item)
    made = []
    for name, (right_deg, up_deg, irradiance, size) in THREE_POINT.items():
        data = bpy.data.lights.new("%s %s" % (NAME, name), "AREA")
        data.shape, data.size = "DISK", size * width
        distance = AREA_AWAY * width
        data.energy = irradiance * math.pi * distance ** 2   # a Lambertian area: intensity on its axis watts / pi
        right, up = math.radians(right_deg), math.radians(up_deg)
        direction = (math.sin(right) * math.cos(up), math.sin(up), math.cos(right) * math.cos(up))
        made.append(_place(scene, item, name, direction, distance, data))
    return made


def directions(seed=0):
    """Of the 36 + 1: half a circle before the person in the XOZ and in the YOZ plane, and one at random before it."""
    fixed = [math.radians(5 + 10 * k) for k in range(FIXED // 2)]
    result = [(math.cos(a), 0, math.sin(a)) for a in fixed] + [(0, math.cos(a), math.sin(a)) for a in fixed]
    chance = random.Random(seed)
    z, around = chance.uniform(0.1, 1), chance.uniform(0, 2 * math.pi)
    flat = math.sqrt(1 - z * z)
    return result + [(flat * math.cos(around), flat * math.sin(around), z)]


def paper(scene, item, one_at_a_time, seed=0):
    """The paper's point lights. one_at_a_time: light k shines in frame k alone, and the scene has as many frames; else
    all at once, each a 37th as strong."""
    remove(scene)
    _, width = frame_of(item)
    every, made = directions(seed), []
    chance = random.Random(seed + 1)
    for k, direction in enumerate(every):
        data = bpy.data.lights.new("%s %d" % (NAME, k + 1), "POINT")
        data.shadow_soft_size = 0
        strength = INTENSITY if k < FIXED else chance.uniform(3, 8)
        distance = AWAY * width / 2   # the loss's frame is 2 wide
        data.energy = 4 * math.pi * strength * (width / 2) ** 2 / (1 if one_at_a_time else len(every))
        made.append(_place(scene, item, str(k + 1), direction, distance, data))
    if one_at_a_time:
        scene.frame_start, scene.frame_end = 1, len(every)
        for k, light in enumerate(made):
            for frame in (k, k + 1, k + 2):
                light.hide_render = light.hide_viewport = frame != k + 1
                light.keyframe_insert("hide_render", frame=frame)
                light.keyframe_insert("hide_viewport", frame=frame)
        scene.frame_set(1)
    return made


RIGS = {"THREE_POINT": lambda scene, item: three_point(scene, item),
        "PAPER": lambda scene, item: paper(scene, item, False),
        "PAPER_FRAMES": lambda scene, item: paper(scene, item, True)}


def build(scene, item, kind):
    if kind not in RIGS:
        raise InputError("", kind, "is no rig", "choose one of " + ", ".join(RIGS))
    return RIGS[kind](scene, item)
