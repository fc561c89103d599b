# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders to a file, whole or not at all."""
import errno
import os

import bpy

from .. import compat
from . import image_header, material
from .errors import InputError

KINDS = {".png": "PNG", ".exr": "OPEN_EXR"}


def prepare_scene(scene, samples, preview_samples, **asked):
    """Cycles with so many samples a pixel, final and in the viewport. Device, denoiser, view and compositor stay as
    they are unless asked for: cpu, no_denoiser, plain_view, no_compositor. A denoiser that this Blender was built
    without is always switched off: it would refuse to render. Returns what was changed, in words."""
    before = compat.render_state(scene)
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.preview_samples = samples, preview_samples
    if asked.get("cpu"):
        scene.cycles.device = "CPU"
    if asked.get("no_denoiser") or not compat.can_denoise():
        scene.cycles.use_denoising = scene.cycles.use_preview_denoising = False
    if asked.get("plain_view"):
        compat.set_plain_view(scene)
    if asked.get("no_compositor"):
        compat.set_compositor(scene, False)
    after = compat.render_state(scene)
    return ["%s %s (was %s)" % (name, after[name], before[name]) for name in after if after[name] != before[name]]


def prepare(scene, samples=64, seed=0):
    """For measurements and `humanmaterial relight`: Cycles on the CPU, no denoiser, sRGB without a film curve, no
    compositor."""
    compat.set_cycles(scene, samples, seed)
    compat.set_plain_view(scene)
    compat.set_compositor(scene, False)


def set_pixel_exact(scene, skin, exact):
    """exact: through the matched camera at the maps' size, each pixel of the picture is one of the maps, as in the
    samples (5 dB nearer to them than with softened pixels). Otherwise smooth, for other views and sizes."""
    material.set_interpolation(skin, not exact)
    compat.set_pixel_filter(scene, "BOX" if exact else "SOFT")


def kind_of(path):
    """File format of a name. Throws InputError."""
    kind = KINDS.get(os.path.splitext(path)[1].lower())
    if kind is None:
        raise InputError(path, "", "is neither .png nor .exr", "choose another name for the picture")
    return kind


def check_target(path):
    """Throws InputError if the picture could not be written there."""
    kind_of(path)
    folder = os.path.dirname(os.path.abspath(path))
    if os.path.isdir(path):
        raise InputError(path, "", "is a folder", "choose a file name")
    if not os.path.isdir(folder) or not os.access(folder, os.W_OK):
        raise InputError(folder, "", "is no folder that can be written to", "make it first")


def check_whole(path):
    """Blender says nothing of a disk that is full while it writes: a picture without its end is an OSError."""
    if not os.path.isfile(path):
        raise OSError("Blender wrote no picture")
    try:
        image_header.read_header(path)
    except InputError:
        raise OSError(errno.ENOSPC, "Blender did not write the picture whole", path) from None
    with open(path, "rb") as file:
        os.fsync(file.fileno())


def part_of(path):
    """The name under which a file is written until it is whole."""
    stem, extension = os.path.splitext(os.path.abspath(path))
    return "%s.part%d%s" % (stem, os.getpid(), extension)


def remove(path):
    if os.path.exists(path):
        os.remove(path)


def to_file(scene, path):
    """Renders the scene. PNG: 16-bit sRGB, alpha straight; EXR: linear float, alpha premultiplied."""
    check_target(path)
    temporary = part_of(path)
    before = _set_output(scene, path, temporary)
    try:
        bpy.ops.render.render(write_still=True, scene=scene.name)
        check_whole(temporary)
        os.replace(temporary, path)
    finally:
        restore_output(scene, before)
        remove(temporary)


def in_window(scene, path, report):
    """Like to_file, in Blender's own render window, with its progress and its Esc. Returns at once; report(words) is
    called when the picture is there, or is not."""
    check_target(path)
    temporary = part_of(path)
    before = _set_output(scene, path, temporary)
    show_render(scene, temporary, path, check_whole, lambda words: (restore_output(scene, before), report(words)),
                write_still=True)


def show_render(scene, temporary, path, check, finish, **how):
    """Renders in Blender's render window and returns at once. finish(words) comes when `path` is there, or is not;
    check(temporary) raises OSError where what was written is not whole. Esc leaves nothing."""
    cancelled = []

    def end():
        words = "Wrote %s" % path
        try:
            if cancelled:
                raise OSError("stopped")
            check(temporary)
            os.replace(temporary, path)
        except OSError as error:
            words = "%s was not written: %s" % (os.path.basename(path), error)
        remove(temporary)
        finish(words)

    def completed(*_):
        for name, handler in handlers:
            if handler in getattr(bpy.app.handlers, name):
                getattr(bpy.app.handlers, name).remove(handler)
        bpy.app.timers.register(end, first_interval=0.1)   # scenes must not be changed inside the handler

    def stopped(*_):
        cancelled.append(True)
        completed()

    handlers = ("render_complete", completed), ("render_cancel", stopped)
    for name, handler in handlers:
        getattr(bpy.app.handlers, name).append(handler)
    bpy.ops.render.render("INVOKE_DEFAULT", scene=scene.name, **how)


OUTPUT = ("media_type", "file_format", "color_mode", "color_depth", "exr_codec", "compression")


def output_state(scene):
    """What the scene writes, to be put back by restore_output."""
    settings, image = scene.render, scene.render.image_settings
    return (settings.filepath, settings.use_file_extension,
            {name: getattr(image, name) for name in OUTPUT if hasattr(image, name)})


def _set_output(scene, path, temporary):
    """Makes the scene write `temporary`, a PNG or EXR as `path` says. Returns what it wrote before."""
    before = output_state(scene)
    scene.render.filepath, scene.render.use_file_extension = temporary, False
    compat.set_output(scene, kind_of(path))
    return before


def restore_output(scene, before):
    settings, image = scene.render, scene.render.image_settings
    settings.filepath, settings.use_file_extension = before[:2]
    for name, value in before[2].items():   # the format before the depth that it can have
        try:
            setattr(image, name, value)
        except TypeError:   # of another format than the one that is set
            pass
