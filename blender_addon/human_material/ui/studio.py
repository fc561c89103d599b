# SPDX-License-Identifier: GPL-3.0-or-later
"""Panel "Studio": the photograph behind the person, rigs of lights, videos."""
import os

import bpy
from bpy.props import EnumProperty, FloatProperty, IntProperty, StringProperty
from bpy_extras.io_utils import ImportHelper

from .. import compat
from ..services import animate, environment, plate, rigs, turntable
from .operators import Operator, ReliefOperator
from .panels import Panel

RIG_ITEMS = [("THREE_POINT", "Three-Point", "Key, fill and rim light"),
             ("PAPER", "36 + 1", "The point lights of the paper's loss, all at once"),
             ("PAPER_FRAMES", "36 + 1, One a Frame", "The same; each shines in a frame of its own")]


class HM_OT_set_plate(Operator, ImportHelper):
    """Put the photograph behind the person: in the camera's view, and under rendered pictures"""
    bl_idname = "hm.set_plate"
    bl_label = "Photograph"
    bl_options = {"REGISTER", "UNDO"}
    filter_glob: StringProperty(default="*.png;*.jpg;*.jpeg;*.tif;*.tiff;*.exr", options={"HIDDEN"})

    def run(self, context):
        image = plate.set_plate(context.scene, bpy.path.abspath(self.filepath))
        context.scene.hm.show_background = False
        if context.scene.view_settings.view_transform != "Standard":
            self.report({"WARNING"}, "The view transform %s changes the photograph too: Prepare Render, F9, View "
                        "Without a Film Curve" % context.scene.view_settings.view_transform)
        return "Over %s" % image.name


class HM_OT_remove_plate(Operator):
    """Take the photograph away; other nodes of the compositor stay"""
    bl_idname = "hm.remove_plate"
    bl_label = "Remove Photograph"
    bl_options = {"REGISTER", "UNDO"}

    def run(self, context):
        plate.remove_plate(context.scene)
        return "No photograph"


class HM_OT_add_ground(ReliefOperator):
    """Add a ground that is seen by the person's shadow alone"""
    bl_idname = "hm.add_ground"
    bl_label = "Shadow on the Ground"
    bl_options = {"REGISTER", "UNDO"}

    def run(self, context):
        return "Added %s" % plate.add_ground(context.scene, context.object).name


class HM_OT_light_rig(ReliefOperator):
    """Light the person by a rig; it replaces the one that is there"""
    bl_idname = "hm.light_rig"
    bl_label = "Light Rig"
    bl_options = {"REGISTER", "UNDO"}
    kind: EnumProperty(name="Rig", items=RIG_ITEMS, default="THREE_POINT")
    dark: bpy.props.BoolProperty(name="No Environment", default=True, description="Only the rig shines")

    def run(self, context):
        made = rigs.build(context.scene, context.object, self.kind)
        if self.dark:
            context.scene.hm.strength = 0.0
            if not environment.has_world(context.scene):
                environment.set_dark(context.scene)
        return "%d lights" % len(made)


class HM_OT_remove_rig(Operator):
    """Take the rig's lights away"""
    bl_idname = "hm.remove_rig"
    bl_label = "Remove Rig"
    bl_options = {"REGISTER", "UNDO"}

    def run(self, context):
        return "Removed %d lights" % rigs.remove(context.scene)


class HM_OT_turntable(ReliefOperator):
    """Key a video: the light goes around the person, or the camera swings before it"""
    bl_idname = "hm.turntable"
    bl_label = "Turntable"
    bl_options = {"REGISTER", "UNDO"}
    what: EnumProperty(name="Turns", items=[("LIGHT", "Light", "The environment, once around"),
                                            ("CAMERA", "Camera", "To both sides and back: a relief has no back")])
    frames: IntProperty(name="Frames", default=120, min=2, max=100000)
    angle_deg: FloatProperty(name="Angle (°)", default=15.0, min=0, max=60, description="Of the camera, to each side")

    def invoke(self, context, event):
        return context.window_manager.invoke_props_dialog(self)

    def run(self, context):
        if self.what == "CAMERA":
            turntable.swing_camera(context.scene, context.object, self.frames, self.angle_deg)
            return "The camera swings by %g° in %d frames" % (self.angle_deg, self.frames)
        if environment.has_world(context.scene):
            animate.environment(context.scene, environment.world_nodes(context.scene), environment.MAPPING,
                                environment.BACKGROUND)
        turntable.light_around(context.scene, self.frames)
        return "The light goes around in %d frames" % self.frames


class HM_OT_render_video(Operator):
    """Render the scene's frames into a video (MP4, MKV, WebM)"""
    bl_idname = "hm.render_video"
    bl_label = "Render Video"
    filepath: StringProperty(subtype="FILE_PATH", options=compat.path_options())
    filter_glob: StringProperty(default="*.mp4;*.mkv;*.webm", options={"HIDDEN"})
    check_existing: bpy.props.BoolProperty(default=True, options={"HIDDEN"})

    def invoke(self, context, event):
        self.filepath = self.filepath or "turntable.mp4"
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def run(self, context):
        path = bpy.path.abspath(self.filepath)
        environment.check_present(context.scene)
        if bpy.app.background:
            turntable.to_file(context.scene, path)
            return "Wrote %s" % path
        turntable.in_window(context.scene, path, print)
        return "Rendering %s; Esc stops" % os.path.basename(path)


class HM_PT_studio(Panel, bpy.types.Panel):
    bl_label = "Studio"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.prepared()
        column = layout.column(align=True)
        column.operator("hm.set_plate", icon="IMAGE_BACKGROUND")
        column.operator("hm.remove_plate", icon="X")
        column.operator("hm.add_ground", icon="MESH_PLANE")
        column = layout.column(align=True)
        column.operator_menu_enum("hm.light_rig", "kind", icon="LIGHT_AREA")
        column.operator("hm.remove_rig", icon="X")
        column = layout.column(align=True)
        column.operator("hm.turntable", icon="FILE_REFRESH")
        column.operator("hm.render_video", icon="RENDER_ANIMATION")


CLASSES = (HM_OT_set_plate, HM_OT_remove_plate, HM_OT_add_ground, HM_OT_light_rig, HM_OT_remove_rig, HM_OT_turntable,
           HM_OT_render_video, HM_PT_studio)
