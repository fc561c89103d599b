# SPDX-License-Identifier: GPL-3.0-or-later
"""Small pictures of environments to choose from: those used last, then those of the preferences' folder."""
import os
import time
import zlib

import bpy
import bpy.utils.previews

from .. import compat
from ..services import recent
from . import preferences

_pictures = None   # bpy's collection
_items = []        # kept: Blender does not keep the texts of dynamic enums
_looked_at = -1e9  # when the folders were last read: panels ask at every drawing
EACH_S = 2.0


def file():
    return os.path.join(compat.user_folder(preferences.PACKAGE), "environments.json")


def paths():
    found = recent.read(file())
    return found + [p for p in recent.of_folder(preferences.environments()) if p not in found]


def items(_self, _context):
    """For an EnumProperty: the identifier is the path; the number stays the path's own when the order changes."""
    global _looked_at
    if _items and time.monotonic() - _looked_at < EACH_S:
        return _items
    _looked_at = time.monotonic()
    _items.clear()
    for path in paths():
        icon = 0
        if _pictures is not None:
            if path not in _pictures:
                _pictures.load(path, path, "IMAGE")
            icon = _pictures[path].icon_id
        _items.append((path, os.path.splitext(os.path.basename(path))[0], path, icon, zlib.crc32(path.encode()) >> 1))
    if not _items:
        _items.append(("", "None yet", "Choose one with Environment", 0, 0))
    return _items


def show(settings, path):
    """The picture that is chosen otherwise is the one that is shown."""
    global _looked_at
    _looked_at = -1e9
    try:
        settings.environment_file = path
    except TypeError:   # not among those that are kept
        pass


def register():
    global _pictures
    if not bpy.app.background:
        _pictures = bpy.utils.previews.new()


def unregister():
    global _pictures
    if _pictures is not None:
        bpy.utils.previews.remove(_pictures)
        _pictures = None
    _items.clear()
