# SPDX-License-Identifier: GPL-3.0-or-later
"""One garment of a person: picked by a click, edited by itself."""
import bpy
from bpy.props import IntProperty

from ..services import edit, garment_edit, relief
from ..services.errors import InputError
from . import label_paint
from .operators import ReliefOperator


class HM_OT_edit_garment(ReliefOperator):
    """Edit one garment by itself: click it"""
    bl_idname = "hm.edit_garment"
    bl_label = "Pick a Garment"
    bl_options = {"REGISTER", "UNDO"}
    garment: IntProperty(name="Garment", default=0, min=0, max=255, options={"SKIP_SAVE"})

    def invoke(self, context, event):
        if self.garment or context.area is None or context.area.type != "VIEW_3D":
            return self.execute(context)
        context.window.cursor_modal_set("EYEDROPPER")
        context.window_manager.modal_handler_add(self)
        self.report({"INFO"}, "Click a garment; Esc stops")
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type in {"ESC", "RIGHTMOUSE"}:
            context.window.cursor_modal_restore()
            return {"CANCELLED"}
        if event.type != "LEFTMOUSE" or event.value != "PRESS":
            return {"PASS_THROUGH"}
        context.window.cursor_modal_restore()
        try:
            self.garment = self.under(context, event)
        except InputError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return self.execute(context)

    def under(self, context, event):
        """Number of the garment under the pointer."""
        item = context.object
        region = next(r for r in context.area.regions if r.type == "WINDOW")
        with context.temp_override(region=region):
            origin, direction = label_paint.ray(bpy.context, item, event.mouse_x - region.x, event.mouse_y - region.y)
        found, _, _, face = item.ray_cast(origin, direction)
        if not found:
            raise InputError("", "", "there is no garment at that place", "click on the person")
        u, v = item.data.uv_layers.active.data[item.data.polygons[face].loop_start].uv
        return garment_edit.garment_at(relief.material_of(item), u, v)[0]

    def run(self, context):
        key, _ = garment_edit.node_for(relief.material_of(context.object), self.garment)
        return "Garment %d: its sliders are in Edit > %s" % (self.garment, edit.class_of(key).capitalize())


CLASSES = (HM_OT_edit_garment,)
