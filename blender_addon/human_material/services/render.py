# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders to a file, whole or not at all."""
import errno
import os

import bpy

from .. import compat
from . import image_header, material
from .errors import InputError

KINDS = {".png": "PNG", ".exr": "OPEN_EXR"}


def prepare(scene, samples=64, seed=0):
    """Cycles, sRGB without a film curve, background transparent unless it was asked for."""
    compat.set_cycles(scene, samples, seed)
    compat.set_plain_view(scene)
    scene.use_nodes = False


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


def to_file(scene, path):
    """Renders the scene. PNG: 16-bit sRGB, alpha straight; EXR: linear float, alpha premultiplied."""
    check_target(path)
    path = os.path.abspath(path)
    stem, extension = os.path.splitext(path)
    temporary = "%s.part%d%s" % (stem, os.getpid(), extension)
    settings = scene.render
    before = settings.filepath, settings.use_file_extension
    settings.filepath, settings.use_file_extension = temporary, False
    compat.set_output(scene, kind_of(path))
    try:
        bpy.ops.render.render(write_still=True, scene=scene.name)
        check_whole(temporary)
        os.replace(temporary, path)
    finally:
        settings.filepath, settings.use_file_extension = before
        if os.path.exists(temporary):
            os.remove(temporary)
