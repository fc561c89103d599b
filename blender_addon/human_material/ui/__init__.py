# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators and panels of the sidebar tab "Human Material"."""
import bpy

from ..services import watch
from . import (files, garment_operators, job_loop, label_loop, label_operators, label_paint, label_panels, label_properties,
               operators, panels, preferences, properties, studio, thumbnails, tool_operators, tool_panels,
               tool_properties)

#: in the order of the sidebar; settings first
MODULES = (preferences, label_properties, tool_properties, properties, job_loop, operators, label_paint, label_operators,
           garment_operators, tool_operators, label_panels, panels, studio, files, tool_panels)
CLASSES = tuple(cls for module in MODULES for cls in module.CLASSES)


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.hm = bpy.props.PointerProperty(type=properties.HM_PG_scene)
    watch.register()
    label_loop.register()
    label_paint.register()
    thumbnails.register()
    files.register()


def unregister():
    files.unregister()
    thumbnails.unregister()
    label_paint.unregister()
    label_loop.unregister()
    watch.unregister()
    del bpy.types.Scene.hm
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
