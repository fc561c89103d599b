# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators of the Label panel, but for the brush (label_paint.py)."""
import json
import os

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty
from mathutils import Vector

from .. import compat
from ..services import label_session, regions, scan_object, strokes
from ..services.errors import InputError
from . import job_loop, label_loop, label_paint, label_properties, preferences
from .operators import DroppableOperator, Operator

WAIT_S = 3600   # without a window; a session ends one that hangs by itself


class HM_OT_open_scan(DroppableOperator):
    """Open a scan to label it: OBJ, GLB or FBX, as `openhumanbrdf` reads it"""
    bl_idname = "hm.open_scan"
    bl_label = "Open Scan"
    filename_ext = ".obj"
    filter_glob: StringProperty(default="*.obj;*.glb;*.gltf;*.fbx", options={"HIDDEN"})
    unit: EnumProperty(name="Unit", items=label_properties.UNIT_ITEMS, default="GUESS")
    up: EnumProperty(name="Up", items=label_properties.UP_ITEMS, default="Y")
    strokes: StringProperty(name="Strokes", description="A strokes.xml to go on with", options={"SKIP_SAVE"})

    def run(self, context):
        path = os.path.abspath(bpy.path.abspath(self.filepath))
        first, sha256 = strokes.read(bpy.path.abspath(self.strokes)) if self.strokes else ([], "")
        session = label_session.open_scan(
            preferences.find("openhumanbrdf"), path, "" if self.unit == "GUESS" else self.unit,
            "" if self.up == "Y" else self.up.lower(), first)
        if bpy.app.background:
            label_loop.wait(lambda: session.phase == "ended" or session.is_settled(), WAIT_S)
            if session.phase == "ended":
                raise InputError("", "", session.status)
            return "%s: %d faces" % (session.name, len(session.classes))
        return "Reading %s" % os.path.basename(path)


class ScanOperator(Operator):
    """Base of what works on the active scan."""

    @classmethod
    def poll(cls, context):
        if not scan_object.is_scan(context.object) or context.mode != "OBJECT":
            cls.poll_message_set("Select a scan that was opened in the Label panel, in Object Mode")
            return False
        return True


class HM_OT_label_start(ScanOperator):
    """Start the program for a scan of an earlier session; the strokes are in the scene"""
    bl_idname = "hm.label_start"
    bl_label = "Go On"

    def run(self, context):
        session = label_session.resume(preferences.find("openhumanbrdf"), context.object)
        session.shown = context.scene.hm.label.show
        if bpy.app.background:
            label_loop.wait(lambda: session.phase == "ended" or session.is_settled(), WAIT_S)
            if session.phase == "ended":
                raise InputError("", "", session.status)
        return "Reading the scan"


class HM_OT_label_tool(ScanOperator):
    """Take the brush in hand: the left button paints"""
    bl_idname = "hm.label_tool"
    bl_label = "Paint"

    def run(self, context):
        bpy.ops.wm.tool_set_by_id(name="hm.label_brush")
        return "Paint with the left button; [ and ] change the size"


class HM_OT_label_answer(ScanOperator):
    """Say what this whole garment is made of"""
    bl_idname = "hm.label_answer"
    bl_label = "Answer"
    bl_options = {"REGISTER", "UNDO"}
    garment: StringProperty()
    class_name: EnumProperty(items=label_properties.CLASS_ITEMS)

    def run(self, context):
        session = label_paint.ready_session(context)
        question = next((q for q in session.questions if q["id"] == self.garment), None)
        if question is None:
            raise InputError("", self.garment, "is not asked about any more")
        label_paint.add_strokes(context.object, [{"class": self.class_name, "radius_cm": 1.0,
                                                  "points": [[question["face"], *question["at"]]]}])
        return "%s: %s" % (self.garment.capitalize(), self.class_name)


class HM_OT_label_look(ScanOperator):
    """Show where a stroke would help most, or the garment that is asked about"""
    bl_idname = "hm.label_look"
    bl_label = "Look There"
    garment: StringProperty(description="Empty: the place of the next stroke")

    def run(self, context):
        found = self.place(context)
        if context.region_data is not None:
            set_view(context.region_data, self.goal(context, found))
        return "Now %s; %s?" % (found["now"], found["rival"])

    def place(self, context):
        """The answer's entry. Raises InputError if there is none."""
        session = label_paint.ready_session(context)
        found = (next((q for q in session.questions if q["id"] == self.garment), None) if self.garment
                 else session.suggested)
        if found is None:
            raise InputError("", "", "no place is in doubt", "save")
        return found

    def goal(self, context, found):
        item, session = context.object, label_paint.ready_session(context)
        normal = item.matrix_world.to_3x3() @ face_normal(session.scan, found["face"])
        return view_of(context.region_data, item.matrix_world @ Vector(found["at"]), normal,
                       0.6 if self.garment else 0.35)

    def invoke(self, context, event):
        if context.region_data is None:
            return self.execute(context)
        try:
            found = self.place(context)
        except InputError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        view = context.region_data
        self.start = view.view_location.copy(), view.view_rotation.copy(), view.view_distance
        self.end, self.step = self.goal(context, found), 0
        self.timer = context.window_manager.event_timer_add(0.02, window=context.window)
        context.window_manager.modal_handler_add(self)
        self.report({"INFO"}, "Now %s; %s?" % (found["now"], found["rival"]))
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        """The view flies: so the artist sees where to."""
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        self.step += 1
        if context.region_data is None or self.step > FLIGHT:   # the area has gone
            context.window_manager.event_timer_remove(self.timer)
            return {"FINISHED"}
        t = self.step / FLIGHT
        t = t * t * (3 - 2 * t)
        (a, turned, near), (b, goal, far) = self.start, self.end
        set_view(context.region_data, (a.lerp(b, t), turned.slerp(goal, t), near + t * (far - near)))
        return {"PASS_THROUGH"}


FLIGHT = 15   # steps


def set_view(view, goal):
    view.view_location, view.view_rotation, view.view_distance = goal
    view.update()


def face_normal(scan, face):
    """Newell's, in the scan's axes; of no length for a face of no area."""
    places = [Vector(scan.positions[3 * v:3 * v + 3])
              for v in (scan.faces.vertices[c] for c in scan.faces.corners(face))]
    total = Vector((0, 0, 0))
    for a, b in zip(places, places[1:] + places[:1]):
        total += a.cross(b)
    return total.normalized()


def view_of(view, place, normal, distance_m):
    """(location, rotation, distance) of a view of a place, mostly from where the surface faces; upright."""
    flat = Vector((normal.x, normal.y, min(max(normal.z, -0.5), 0.5)))
    rotation = upright(flat.normalized()) if flat.xy.length > 1e-3 else view.view_rotation.copy()
    return place, rotation, distance_m


def upright(back):
    """The rotation of a view that looks against `back` with +Z up."""
    from mathutils import Matrix
    right = Vector((0, 0, 1)).cross(back).normalized()
    return Matrix((right, back.cross(right), back)).transposed().to_quaternion()


class HM_OT_save_strokes(ScanOperator):
    """Save the strokes, for `openhumanbrdf label --strokes`"""
    bl_idname = "hm.save_strokes"
    bl_label = "Save Strokes"
    filepath: StringProperty(subtype="FILE_PATH", options=compat.path_options())
    filter_glob: StringProperty(default="*.xml", options={"HIDDEN"})
    check_existing: BoolProperty(default=True, options={"HIDDEN"})
    overwrite: BoolProperty(name="Overwrite", default=False, options={"SKIP_SAVE"},
                            description="Replace strokes that this window did not write")

    def invoke(self, context, event):
        self.filepath = os.path.splitext(context.object[scan_object.SCAN])[0] + ".strokes.xml"
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def run(self, context):
        path, item = bpy.path.abspath(self.filepath), context.object
        found = scan_object.strokes_of(item)
        self.expect_ours(path, item)
        scan_object.expect_unchanged(item)
        item[scan_object.SAVED] = regions.write_strokes(path, found, item[scan_object.SHA256])
        return "Wrote %d strokes: %s" % (len(found), path)


    def expect_ours(self, path, item):
        """Raises InputError for the strokes of another scan, or, unless told, of another window on this one."""
        if not os.path.exists(path):
            return
        if strokes.read(path)[1] not in ("", item[scan_object.SHA256]):
            raise InputError(path, "", "holds the strokes of another scan", "choose another name")
        if not self.overwrite and regions.print_of(path) != item.get(scan_object.SAVED):
            raise InputError(path, "", "holds strokes that were not saved from here", "choose another name, or Overwrite")


class HM_OT_save_regions(ScanOperator):
    """Label the scan by its strokes with the command line's program and save REGIONS, which `bake` reads"""
    bl_idname = "hm.save_regions"
    bl_label = "Save Regions"
    directory: StringProperty(subtype="DIR_PATH", options=compat.path_options())
    folder_name: StringProperty(name="New Folder", default="regions", description="Made in the folder that is chosen")

    def invoke(self, context, event):
        self.directory = os.path.dirname(context.object[scan_object.SCAN])
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def run(self, context):
        item = context.object
        scan_object.expect_unchanged(item)
        output = os.path.join(bpy.path.abspath(self.directory), self.folder_name)
        job_loop.expect_free("label")
        name, tools = item.name, context.scene.hm.tools
        tools.scan, tools.regions = item[scan_object.SCAN], output   # what the panel Bake reads
        words = job_loop.start(regions.saving(
            preferences.find("openhumanbrdf"), item[scan_object.SCAN], scan_object.strokes_of(item),
            item[scan_object.SHA256], json.loads(item[scan_object.OPTIONS]), output,
            lambda _: label_loop.take_over(name, output)))
        if bpy.app.background:
            label_loop.step()
        return words


CLASSES = (HM_OT_open_scan, HM_OT_label_start, HM_OT_label_tool, HM_OT_label_answer, HM_OT_label_look,
           HM_OT_save_strokes, HM_OT_save_regions)
