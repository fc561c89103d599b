# SPDX-License-Identifier: GPL-3.0-or-later
"""Panel "Label": the regions of a scan, by strokes."""
import os

import bpy

from ..services import label_session, scan_object
from . import job_loop
from .panels import Panel


class HM_PT_label(Panel, bpy.types.Panel):
    bl_label = "Label"

    def draw(self, context):
        layout = self.prepared()
        layout.operator("hm.open_scan", icon="IMPORT")
        for session in label_session.opening:
            layout.label(text="%s: %s" % (os.path.basename(session.path), session.status), icon="SORTTIME")
        item = context.object
        if not scan_object.is_scan(item):
            layout.label(text="Open or select a scan")
            return
        session = label_session.of(item)
        if session is None or session.phase == "ended":
            layout.label(text=item.name)
            layout.operator("hm.label_start", icon="PLAY")
        else:
            draw_painting(layout, context, session)
        draw_saving(layout, context)


def draw_painting(layout, context, session):
    settings = context.scene.hm.label
    layout.label(text=session.status)
    grid = layout.grid_flow(row_major=True, columns=2, even_columns=True, align=True)
    grid.use_property_split = False
    grid.prop(settings, "class_name", expand=True)
    grid = layout.grid_flow(row_major=True, columns=2, even_columns=True, align=True)
    grid.use_property_split = False
    grid.prop(settings, "mode", expand=True)
    layout.prop(settings, "radius_cm")
    layout.prop(settings, "use_pressure")
    layout.operator("hm.label_tool", icon="BRUSH_DATA")
    row = layout.row(align=True)
    row.use_property_split = False
    row.prop(settings, "show", expand=True)
    if session.phase == "ready":
        draw_doubt(layout, session)


def draw_doubt(layout, session):
    layout.label(text="In doubt: %.0f %% of the faces" % (100 * session.share_in_doubt()))
    if session.suggested:
        layout.operator("hm.label_look", text="Next: %(now)s or %(rival)s?" % session.suggested, icon="VIEWZOOM")
    for question in session.questions:
        box = layout.box()
        row = box.row()
        row.label(text="%s: %s?" % (question["id"].capitalize(), question["now"]))
        row.operator("hm.label_look", text="", icon="VIEWZOOM").garment = question["id"]
        row = box.row(align=True)
        for name in (question["now"], question["rival"]):
            button = row.operator("hm.label_answer", text=name.capitalize())
            button.garment, button.class_name = question["id"], name
    for warning in session.warnings[:2]:
        layout.label(text=warning, icon="ERROR")


def draw_saving(layout, context):
    column = layout.column(align=True)
    column.operator("hm.save_strokes", icon="FILE_TICK")
    column.operator("hm.save_regions", icon="FILE_FOLDER")
    job_loop.draw(layout, "label")
    if context.scene.hm.label.message:
        layout.label(text=context.scene.hm.label.message)


CLASSES = (HM_PT_label,)
