# SPDX-License-Identifier: GPL-3.0-or-later
"""Videos: the light goes once around the person, or the camera swings before it (a relief has no back). The keys are
Blender's own, on the panel's Rotation and on an empty that the camera hangs on."""
import math
import os

import bpy

from .. import compat
from . import camera, render
from .errors import InputError

PIVOT = "HM Turntable"
KINDS = {".mp4": ("MPEG4", "H264"), ".mkv": ("MKV", "H264"), ".webm": ("WEBM", "WEBM")}


def light_around(scene, frames):
    """Keys the environment's rotation once around in so many frames."""
    if frames < 2:
        raise InputError("", "", "%d frames are no video" % frames, "give 2 or more")
    if not hasattr(scene, "hm"):
        raise InputError("", "", "the panel is not there", "enable the add-on")
    scene.frame_start, scene.frame_end = 1, frames
    start = scene.hm.rotation_deg
    for frame, turned in ((1, 0.0), (frames + 1, 360.0)):
        scene.hm.rotation_deg = start + turned
        scene.hm.keyframe_insert("rotation_deg", frame=frame)
    compat.straight_keys(scene, "hm.rotation_deg")
    scene.frame_set(1)


def swing_camera(scene, item, frames, angle_deg):
    """Keys the camera from the left to the right of the person and back, angle_deg to each side."""
    if frames < 2:
        raise InputError("", "", "%d frames are no video" % frames, "give 2 or more")
    lens = camera.match(scene, item)
    pivot = bpy.data.objects.get(PIVOT)
    if pivot is None:
        pivot = bpy.data.objects.new(PIVOT, None)
        scene.collection.objects.link(pivot)
    pivot.animation_data_clear()
    pivot.location, pivot.rotation_euler = item.matrix_basis.to_translation(), (0, 0, 0)
    bpy.context.view_layer.update()
    matrix = lens.matrix_world.copy()
    lens.parent = pivot
    lens.matrix_parent_inverse = pivot.matrix_world.inverted()
    lens.matrix_world = matrix
    scene.frame_start, scene.frame_end = 1, frames
    for frame in range(1, frames + 1):
        pivot.rotation_euler.z = math.radians(angle_deg) * math.sin(2 * math.pi * (frame - 1) / frames)
        pivot.keyframe_insert("rotation_euler", index=2, frame=frame)
    scene.frame_set(1)


def check_target(path):
    if os.path.splitext(path)[1].lower() not in KINDS:
        raise InputError(path, "", "is no video", "choose .mp4, .mkv or .webm")
    folder = os.path.dirname(os.path.abspath(path))
    if not os.path.isdir(folder) or not os.access(folder, os.W_OK):
        raise InputError(folder, "", "is no folder that can be written to", "make it first")


def to_file(scene, path):
    """Renders the scene's frames into a video, whole or not at all; its output settings stay."""
    check_target(path)
    temporary = render.part_of(path)
    before = _set_output(scene, path, temporary)
    try:
        bpy.ops.render.render(animation=True, scene=scene.name)
        _check_video(temporary)
        os.replace(temporary, path)
    except (OSError, RuntimeError) as error:
        raise InputError(path, "", "Blender wrote no video (%s)" % str(error).strip(),
                         "render frames as pictures instead") from None
    finally:
        render.restore_output(scene, before)
        render.remove(temporary)


def in_window(scene, path, report):
    """Like to_file, in Blender's render window: returns at once, Esc leaves nothing, the frame is what it was."""
    check_target(path)
    temporary, frame = render.part_of(path), scene.frame_current
    before = _set_output(scene, path, temporary)

    def finish(words):
        render.restore_output(scene, before)
        scene.frame_set(frame)
        report(words)
    render.show_render(scene, temporary, path, _check_video, finish, animation=True)


def _set_output(scene, path, temporary):
    before = render.output_state(scene)
    try:
        compat.set_video(scene, *KINDS[os.path.splitext(path)[1].lower()])
    except TypeError:
        render.restore_output(scene, before)
        raise InputError(path, "", "this Blender was built without FFmpeg", "render frames as pictures") from None
    scene.render.filepath, scene.render.use_file_extension = temporary, False
    return before


def _check_video(path):
    if not os.path.isfile(path) or os.path.getsize(path) == 0:
        raise OSError("it wrote nothing")
