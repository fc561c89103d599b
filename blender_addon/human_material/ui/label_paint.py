# SPDX-License-Identifier: GPL-3.0-or-later
"""The label tool: what a press of the left button in the 3D view does, by the tool that is chosen in the panel."""
import uuid

import bpy
from bpy_extras import view3d_utils
from mathutils import Vector

from .. import compat
from ..services import fills, label_session, overlay, scan_object, strokes
from ..services.errors import InputError

FILLS = {"MATERIAL": "of_material", "PIECE": "of_piece", "ISLAND": "of_island"}


def ready_session(context):
    """The active scan's session. Raises InputError where nothing can be painted."""
    item = context.object
    if not scan_object.is_scan(item):
        raise InputError("", "", "no scan is selected", "open one with Open Scan, or select it")
    session = label_session.of(item)
    if session is None:
        raise InputError(item.name, "", "its labelling is not running", "press Go On in the Label panel")
    if session.phase != "ready":
        raise InputError(item.name, "", "the scan is still being read", "wait a moment")
    scan_object.expect_unchanged(item)
    return session


def ray(context, item, x, y):
    """Origin and direction of a place in the region, in the scan's own axes."""
    region, view = context.region, context.region_data
    back = item.matrix_world.inverted()
    origin = view3d_utils.region_2d_to_origin_3d(region, view, (x, y))
    direction = view3d_utils.region_2d_to_vector_3d(region, view, (x, y))
    start = back @ origin
    return start, (back @ (origin + direction) - start).normalized()


def seen_inside(context, session, polygon):
    """Faces that a lasso means: their middle is inside it, faces the viewer, and nothing is before it."""
    item = session.item
    matrix = context.region_data.perspective_matrix @ item.matrix_world
    width, height = context.region.width, context.region.height
    found = []
    for face in session.scan.kept:
        place = session.scan.centre(face)
        at = matrix @ Vector((*place, 1.0))
        if at.w <= 0:
            continue
        x, y = (at.x / at.w + 1) / 2 * width, (at.y / at.w + 1) / 2 * height
        if not fills.is_inside(x, y, polygon):
            continue
        hit = session.nearest(*ray(context, item, x, y))
        if hit is not None and (hit[2] == face or (hit[0] - Vector(place)).length * session.unit_cm < 0.2):
            found.append(face)
    return found


def add_strokes(item, new):
    if new:
        scan_object.set_strokes(item, scan_object.strokes_of(item) + new)


def fill(session, class_name, faces):
    """Dots on those faces that have another class; on all if none has."""
    index = strokes.CLASSES.index(class_name)
    others = [f for f in faces if session.classes[f] != index]
    add_strokes(session.item, strokes.of_faces(
        class_name, others or faces, lambda f: [round(c, 6) for c in session.scan.centre(f)], uuid.uuid4().hex[:8]))
    return len(faces)


class HM_OT_label_paint(bpy.types.Operator):
    """Paint a class on the scan. Press and draw; Esc leaves it"""
    bl_idname = "hm.label_paint"
    bl_label = "Paint Class"
    bl_options = {"REGISTER", "UNDO", "BLOCKING"}

    @classmethod
    def poll(cls, context):
        return context.mode == "OBJECT" and context.area is not None and context.area.type == "VIEW_3D"

    def invoke(self, context, event):
        settings = context.scene.hm.label
        try:
            self.session = ready_session(context)
            self.item = self.session.item
            if settings.mode in FILLS:
                return self.fill(context, settings, event)
        except InputError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.painter = strokes.Painter(settings.class_name, settings.radius_cm, self.session.unit_cm)
        self.line, self.pressures = [], []
        self.add(context, event)
        self.handle = bpy.types.SpaceView3D.draw_handler_add(self.draw, (settings,), "WINDOW", "POST_PIXEL")
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def fill(self, context, settings, event):
        hit = self.session.nearest(*ray(context, self.item, event.mouse_region_x, event.mouse_region_y))
        if hit is None:
            return {"PASS_THROUGH"}
        faces = getattr(self.session.scan.faces, FILLS[settings.mode])(hit[2])
        self.report({"INFO"}, "%d faces: %s" % (fill(self.session, settings.class_name, faces), settings.class_name))
        return {"FINISHED"}

    def add(self, context, event):
        x, y = event.mouse_region_x, event.mouse_region_y
        self.line.append((x, y))
        self.pressures.append(event.pressure)
        hit = self.session.nearest(*ray(context, self.item, x, y))
        if hit is None:
            self.painter.leave()
        else:
            self.painter.add(hit[2], [round(c, 6) for c in hit[0]])
        context.area.tag_redraw()

    def modal(self, context, event):
        if event.type in {"MOUSEMOVE", "INBETWEEN_MOUSEMOVE"}:
            self.add(context, event)
        elif event.type == "LEFTMOUSE" and event.value == "RELEASE":
            bpy.types.SpaceView3D.draw_handler_remove(self.handle, "WINDOW")
            context.area.tag_redraw()
            return self.finish(context)
        elif event.type in {"ESC", "RIGHTMOUSE"}:
            bpy.types.SpaceView3D.draw_handler_remove(self.handle, "WINDOW")
            context.area.tag_redraw()
            return {"CANCELLED"}
        return {"RUNNING_MODAL"}

    def finish(self, context):
        settings = context.scene.hm.label
        if settings.mode == "LASSO":
            faces = seen_inside(context, self.session, self.line) if len(self.line) > 2 else []
            if not faces:
                self.report({"WARNING"}, "No face is inside the lasso")
                return {"CANCELLED"}
            self.report({"INFO"}, "%d faces: %s" % (fill(self.session, settings.class_name, faces),
                                                    settings.class_name))
            return {"FINISHED"}
        if not self.painter.lines:   # beside the scan: nothing to undo
            return {"CANCELLED"}
        if settings.mode == "ERASER":
            return self.erase(settings)
        if settings.use_pressure:
            self.painter.radius_cm = max(0.1, settings.radius_cm * sum(self.pressures) / len(self.pressures))
        add_strokes(self.item, self.painter.strokes(uuid.uuid4().hex[:8]))
        return {"FINISHED"}

    def erase(self, settings):
        before = scan_object.strokes_of(self.item)
        path = [point[1:] for line in self.painter.lines for point in line]
        left = strokes.erased(before, path, settings.radius_cm, self.session.unit_cm)
        if len(left) == len(before):
            self.report({"INFO"}, "No stroke is there")
            return {"CANCELLED"}
        scan_object.set_strokes(self.item, left)
        self.report({"INFO"}, "%d strokes taken away" % (len(before) - len(left)))
        return {"FINISHED"}

    def draw(self, settings):
        color = (1, 1, 1) if settings.mode == "ERASER" else overlay.COLORS[strokes.CLASSES.index(settings.class_name)]
        line = self.line + self.line[:1] if settings.mode == "LASSO" else self.line
        compat.draw_line(line, (*color, 1.0), 3)


class HM_OT_label_size(bpy.types.Operator):
    """Make the brush larger or smaller"""
    bl_idname = "hm.label_size"
    bl_label = "Brush Size"
    factor: bpy.props.FloatProperty(default=1.25)

    def execute(self, context):
        settings = context.scene.hm.label
        settings.radius_cm = round(settings.radius_cm * self.factor, 2)
        context.area.tag_redraw()
        return {"FINISHED"}


def _draw_cursor(context, _tool, place):
    """A circle of the brush's size on the surface under the pointer."""
    settings = context.scene.hm.label
    session = label_session.of(context.object)
    if settings.mode not in {"BRUSH", "ERASER"} or session is None or session.phase != "ready":
        return
    x, y = place[0] - context.region.x, place[1] - context.region.y
    hit = session.nearest(*ray(context, session.item, x, y))
    if hit is None:
        return
    world = session.item.matrix_world @ hit[0]
    side = context.region_data.view_rotation @ Vector((settings.radius_cm / 100, 0, 0))
    middle, edge = (view3d_utils.location_3d_to_region_2d(context.region, context.region_data, p)
                    for p in (world, world + side))
    if middle is not None and edge is not None:
        compat.draw_circle(place, (edge - middle).length, (1, 1, 1, 0.9))


class HM_TL_label(bpy.types.WorkSpaceTool):
    bl_space_type = "VIEW_3D"
    bl_context_mode = "OBJECT"
    bl_idname = "hm.label_brush"
    bl_label = "Label Scan"
    bl_description = "Paint a class on a scan that was opened in the Label panel"
    bl_icon = "brush.paint_vertex.draw"
    bl_cursor = "PAINT_CROSS"
    bl_keymap = (
        ("hm.label_paint", {"type": "LEFTMOUSE", "value": "PRESS"}, None),
        ("hm.label_size", {"type": "LEFT_BRACKET", "value": "PRESS"}, {"properties": [("factor", 0.8)]}),
        ("hm.label_size", {"type": "RIGHT_BRACKET", "value": "PRESS"}, {"properties": [("factor", 1.25)]}),
    )

    def draw_settings(context, layout, tool):
        settings = context.scene.hm.label
        layout.prop(settings, "class_name", text="")
        layout.prop(settings, "mode", text="")
        layout.prop(settings, "radius_cm")

    draw_cursor = staticmethod(_draw_cursor)


CLASSES = (HM_OT_label_paint, HM_OT_label_size)


def register():
    if not bpy.app.background:
        bpy.utils.register_tool(HM_TL_label, separator=True)


def unregister():
    if not bpy.app.background:
        bpy.utils.unregister_tool(HM_TL_label)
