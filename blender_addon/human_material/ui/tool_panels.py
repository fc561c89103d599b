# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels "Bake", "Produce" and "Validate": the programs, and what they brought."""
import os

import bpy

from ..services import jobs, tools
from . import job_loop
from .panels import Panel
from .tool_operators import path_of, sheet


class ToolPanel(Panel):
    """Fields, the button that starts, the job, the results."""
    bl_options = {"DEFAULT_CLOSED"}
    kind, fields, buttons = "", (), ()

    def draw(self, context):
        layout = self.prepared()
        settings = context.scene.hm.tools
        column = layout.column(align=True)
        for name in self.fields:
            column.prop(settings, name)
        column = layout.column(align=True)
        column.enabled = jobs.of(self.kind) is None
        for operator, icon in self.buttons:
            column.operator(operator, icon=icon)
        job_loop.draw(layout, self.kind)
        self.draw_results(layout, settings)


class HM_PT_bake(ToolPanel, bpy.types.Panel):
    bl_label = "Bake"
    kind = "bake"
    fields = ("scan", "regions", "size_px", "delight", "model")
    buttons = (("hm.bake", "OUTPUT"),)

    def draw_results(self, layout, settings):
        row = layout.row()
        row.enabled = os.path.isfile(os.path.join(path_of(settings, "model"), "model.xml"))
        row.operator("hm.show_model", icon="TEXTURE")


class HM_PT_produce(ToolPanel, bpy.types.Panel):
    bl_label = "Produce"
    kind = "produce"
    fields = ("plan", "dataset", "workers")
    buttons = (("hm.forecast", "TIME"), ("hm.produce", "PLAY"), ("hm.show_samples", "IMAGE_DATA"))

    def draw_results(self, layout, settings):
        if not settings.dataset:
            return
        image = sheet(settings)
        if image is not None and image.preview is not None:
            layout.template_icon(icon_value=image.preview.icon_id, scale=8)
        page = os.path.join(tools.page_of(path_of(settings, "dataset")), "index.html")
        if os.path.isfile(page):
            layout.operator("hm.open_page", icon="URL").path = page


class HM_PT_validate(ToolPanel, bpy.types.Panel):
    bl_label = "Validate"
    kind = "validate"
    fields = ("model", "environment", "turn_deg", "view_px", "spp", "seeds", "report", "blender")
    buttons = (("hm.validate", "VIEWZOOM"),)

    def draw_results(self, layout, settings):
        page = os.path.join(path_of(settings, "report"), "index.html")
        if settings.report and os.path.isfile(page):
            column = layout.column(align=True)
            column.operator("hm.open_page", icon="URL").path = page
            column.operator("hm.open_cycles_scene", icon="FILE_BLEND")


CLASSES = (HM_PT_bake, HM_PT_produce, HM_PT_validate)
