# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators and panels of the sidebar tab "Human Material"."""
import bpy

from ..services import watch
from . import operators, panels, properties

CLASSES = (*properties.CLASSES, *operators.CLASSES, *panels.CLASSES)


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.hm = bpy.props.PointerProperty(type=properties.HM_PG_scene)
    watch.register()


def unregister():
    watch.unregister()
    del bpy.types.Scene.hm
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
