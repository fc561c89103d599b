# SPDX-License-Identifier: GPL-3.0-or-later
"""Thin operators: poll, one call of a service, a report. Bad input ends in a report and changes nothing."""
import os

import bpy
from bpy.props import BoolProperty, EnumProperty, IntProperty, StringProperty
from bpy_extras.io_utils import ImportHelper

from .. import compat
from ..services import (animate, camera, classes, edit, environment, garment_edit, lights, material, presets, recent,
                        relief, render)
from ..services.errors import InputError
from . import thumbnails

CLASS_ITEMS = [(entry["name"], entry["label"], "") for entry in classes.TABLE]
PRESET_ITEMS = [(p.name, p.label, "") for p in presets.PRESETS.values()]


class Operator(bpy.types.Operator):
    """Base: turns InputError into a report."""

    def execute(self, context):
        try:
            self.report({"INFO"}, self.run(context))
        except InputError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


class ReliefOperator(Operator):
    """Base of what works on the active relief."""

    @classmethod
    def poll(cls, context):
        if relief.material_of(context.object) is None:
            cls.poll_message_set("Select a person that was imported from a maps folder")
            return False
        return True


class DroppableOperator(Operator, ImportHelper):
    """Base of what opens a file: by its dialog, or the file that was dropped on the window."""
    filepath: StringProperty(subtype="FILE_PATH", options={"SKIP_SAVE", *compat.path_options()})

    def invoke(self, context, event):
        return self.execute(context) if self.filepath else ImportHelper.invoke(self, context, event)


class HM_OT_import_maps(DroppableOperator):
    """Import the person of a maps folder (maps.json) and match the scene's camera"""
    bl_idname = "hm.import_maps"
    bl_label = "Import Maps"
    bl_options = {"REGISTER", "UNDO"}
    filename_ext = ".json"
    filter_glob: StringProperty(default="*.json", options={"HIDDEN"})
    match_camera: BoolProperty(name="Match Camera", default=True,
                               description="Camera and resolution become those of the person's picture")

    def draw(self, context):
        settings = context.scene.hm
        self.layout.use_property_split = True
        self.layout.prop(self, "match_camera")
        self.layout.prop(settings, "jump_cm", text="Cut (cm)")
        self.layout.prop(settings, "subsurface_method", text="Scatter")
        self.layout.prop(settings, "subsurface_scale", text="Scale")

    def run(self, context):
        settings = context.scene.hm
        item, loaded = relief.load_into(context.scene, bpy.path.abspath(self.filepath), settings.jump_cm,
                                        self.match_camera, settings.subsurface_method)
        material.set_subsurface_scale(relief.material_of(item), settings.subsurface_scale)
        animate.subsurface(context.scene, relief.material_of(item), material.SUBSURFACE_SCALE)
        if settings.scatter_everywhere:
            material.set_visible_scattering(relief.material_of(item), 0)
        material.set_interpolation(relief.material_of(item), smooth=not settings.pixel_exact)
        for other in context.selected_objects:
            other.select_set(False)
        item.select_set(True)
        context.view_layer.objects.active = item
        hidden = relief.hide_default_cube(context.scene, item)
        if hidden:
            self.report({"WARNING"}, "%s stood in the person and is hidden" % hidden)
        shining = [other.name for other in context.scene.objects
                   if other.type == "LIGHT" and not other.hide_render and lights.NAME not in other.name]
        if shining:
            self.report({"WARNING"}, "Lit by the scene's lights too: %s" % ", ".join(shining[:3]))
        for warning in loaded.warnings:
            self.report({"WARNING"}, warning)
        return "%s: %d x %d pixels, %d faces" % (item.name, *loaded.size, len(item.data.polygons))


class HM_OT_match_camera(ReliefOperator):
    """Make the scene's camera and resolution those of the person's picture"""
    bl_idname = "hm.match_camera"
    bl_label = "Match Camera"
    bl_options = {"REGISTER", "UNDO"}

    def run(self, context):
        return "%s matches %s" % (camera.match(context.scene, context.object).name, context.object.name)


class HM_OT_set_environment(DroppableOperator):
    """Light the scene by a latitude-longitude picture (EXR or HDR)"""
    bl_idname = "hm.set_environment"
    bl_label = "Environment"
    bl_options = {"REGISTER", "UNDO"}
    filename_ext = ".exr"
    filter_glob: StringProperty(default="*.exr;*.hdr", options={"HIDDEN"})

    def run(self, context):
        settings = context.scene.hm
        image = environment.set_environment(context.scene, bpy.path.abspath(self.filepath),
                                            settings.rotation_deg, settings.strength)
        animate.environment(context.scene, environment.world_nodes(context.scene), environment.MAPPING,
                            environment.BACKGROUND)
        environment.show_background(context.scene, settings.show_background)
        path = environment.path_of(context.scene)
        recent.add(thumbnails.file(), path)
        thumbnails.show(settings, path)
        return "Lit by %s" % image.name


class HM_OT_rotate_light(bpy.types.Operator):
    """Turn the environment by dragging the pointer to the side. A click takes it, Esc leaves it"""
    bl_idname = "hm.rotate_light"
    bl_label = "Drag to Rotate"
    bl_options = {"REGISTER", "UNDO", "BLOCKING", "GRAB_CURSOR"}
    DEG_PER_PX = 0.5

    @classmethod
    def poll(cls, context):
        return environment.has_world(context.scene)

    def invoke(self, context, event):
        self.start_x, self.start_deg = event.mouse_x, context.scene.hm.rotation_deg
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "MOUSEMOVE":
            context.scene.hm.rotation_deg = self.start_deg + self.DEG_PER_PX * (event.mouse_x - self.start_x)
        elif event.type in {"ESC", "RIGHTMOUSE"}:
            context.scene.hm.rotation_deg = self.start_deg
            return {"CANCELLED"}
        elif event.type in {"LEFTMOUSE", "RET"} and event.value == "PRESS":
            return {"FINISHED"}
        return {"RUNNING_MODAL"}


class HM_OT_add_point_light(Operator):
    """Add a point light of no size at the given position"""
    bl_idname = "hm.add_point_light"
    bl_label = "Add Point Light"
    bl_options = {"REGISTER", "UNDO"}

    def run(self, context):
        settings = context.scene.hm
        return "Added %s" % lights.add_point(context.scene, settings.point_cm, settings.point_intensity).name


class HM_OT_apply_preset(ReliefOperator):
    """Give one class of the person another material or colour; the rest stays"""
    bl_idname = "hm.apply_preset"
    bl_label = "Apply Preset"
    bl_options = {"REGISTER", "UNDO"}
    class_name: EnumProperty(name="Class", items=CLASS_ITEMS, default="fabric")
    garment: IntProperty(name="Garment", default=0, min=0, description="0: all of the class", options={"SKIP_SAVE"})
    preset: EnumProperty(name="Preset", items=PRESET_ITEMS, default="shiny_leather")

    def run(self, context):
        skin = relief.material_of(context.object)
        edit.expect_present(skin, self.class_name)
        edit.apply(skin, edit_key(skin, self), presets.PRESETS[self.preset])
        return "%s: %s" % (self.class_name.capitalize(), presets.PRESETS[self.preset].label)


class HM_OT_reset_edit(ReliefOperator):
    """Undo every edit of one class, or of one garment"""
    bl_idname = "hm.reset_edit"
    bl_label = "Reset"
    bl_options = {"REGISTER", "UNDO"}
    class_name: EnumProperty(name="Class", items=CLASS_ITEMS, default="fabric")
    garment: IntProperty(name="Garment", default=0, min=0, description="0: all of the class", options={"SKIP_SAVE"})

    def run(self, context):
        skin = relief.material_of(context.object)
        edit.reset(skin, edit_key(skin, self))
        return "%s as imported" % self.class_name.capitalize()


def edit_key(skin, operator):
    """Of the class, or of its garment."""
    return garment_edit.node_for(skin, operator.garment)[0] if operator.garment else operator.class_name


class HM_OT_prepare_render(Operator):
    """Set Cycles and the numbers of samples. Device, denoiser, view and compositor stay unless asked for"""
    bl_idname = "hm.prepare_render"
    bl_label = "Prepare Render"
    bl_options = {"REGISTER", "UNDO"}
    plain_view: BoolProperty(name="View Without a Film Curve", description="sRGB of the linear values, as "
                             "`humanmaterial relight` writes")
    no_denoiser: BoolProperty(name="No Denoiser")
    cpu: BoolProperty(name="On the CPU")
    no_compositor: BoolProperty(name="No Compositor")

    def run(self, context):
        settings = context.scene.hm
        changed = render.prepare_scene(context.scene, settings.samples, settings.preview_samples,
                                       plain_view=self.plain_view, no_denoiser=self.no_denoiser, cpu=self.cpu,
                                       no_compositor=self.no_compositor)
        settings.pixel_exact = settings.pixel_exact   # applies it to every person
        environment.show_background(context.scene, settings.show_background)
        try:
            environment.check_present(context.scene)
        except InputError as error:
            self.report({"WARNING"}, str(error))
        return "Changed: " + "; ".join(changed) if changed else "Nothing had to be changed"


class HM_OT_render_picture(Operator):
    """Render the scene into a PNG or EXR file"""
    bl_idname = "hm.render_picture"
    bl_label = "Render Picture"
    filepath: StringProperty(subtype="FILE_PATH", options=compat.path_options())
    filter_glob: StringProperty(default="*.png;*.exr", options={"HIDDEN"})
    check_existing: BoolProperty(default=True, options={"HIDDEN"})
    overwrite: BoolProperty(name="Overwrite", default=False, options={"SKIP_SAVE"},
                            description="Replace a picture of that name")

    @classmethod
    def poll(cls, context):
        if context.scene.camera is None:
            cls.poll_message_set("The scene has no camera: import maps or match the camera")
            return False
        return True

    def invoke(self, context, event):
        if self.filepath and self.overwrite:   # asked and answered
            return self.execute(context)
        self.filepath = self.filepath or "relit.png"
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def run(self, context):
        path = bpy.path.abspath(self.filepath)
        render.check_target(path)
        environment.check_present(context.scene)
        if os.path.exists(path) and not self.overwrite:
            if bpy.app.background:
                raise InputError(path, "", "is there already", "set overwrite, or choose another name")
            bpy.ops.hm.overwrite_picture("INVOKE_DEFAULT", filepath=path)
            return "Overwrite %s?" % os.path.basename(path)
        if bpy.app.background:
            try:
                render.to_file(context.scene, path)
            except RuntimeError as error:   # a denoiser that this Blender was built without, for one
                raise InputError(path, "", "Blender did not render: %s" % str(error).strip(),
                                 "Prepare Render may help") from None
            return "Wrote %s" % path
        render.in_window(context.scene, path, print)
        return "Rendering %s; Esc stops" % os.path.basename(path)


class HM_OT_overwrite_picture(bpy.types.Operator):
    """Replace the picture that is there"""
    bl_idname = "hm.overwrite_picture"
    bl_label = "Overwrite the Picture That Is There"
    bl_options = {"INTERNAL"}
    filepath: StringProperty(subtype="FILE_PATH", options=compat.path_options())

    def invoke(self, context, event):
        return context.window_manager.invoke_confirm(self, event)

    def execute(self, context):
        return bpy.ops.hm.render_picture("EXEC_DEFAULT", filepath=self.filepath, overwrite=True)


CLASSES = (HM_OT_import_maps, HM_OT_match_camera, HM_OT_set_environment, HM_OT_rotate_light, HM_OT_add_point_light,
           HM_OT_apply_preset, HM_OT_reset_edit, HM_OT_prepare_render, HM_OT_render_picture,
           HM_OT_overwrite_picture)
