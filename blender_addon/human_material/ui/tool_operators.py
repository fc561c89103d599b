# SPDX-License-Identifier: GPL-3.0-or-later
"""Bake, Produce, Validate: the command line's programs beside the artist, and what they bring."""
import os
import pathlib
import subprocess

import bpy

from .. import compat
from ..services import baked, environment, scan_object, tools
from ..services.errors import InputError
from . import job_loop, preferences
from .operators import Operator

PROGRAM = "openhumanbrdf"


def path_of(settings, name):
    value = getattr(settings, name)
    return os.path.normpath(bpy.path.abspath(value)) if value else ""


class ToolOperator(Operator):
    """Base: starts one job of its kind."""
    kind = ""

    def run(self, context):
        job_loop.expect_free(self.kind)
        return job_loop.start(self.job(context.scene, context.scene.hm.tools))


class HM_OT_bake(ToolOperator):
    """Bake the labelled scan: its maps as `openhumanbrdf bake` makes them. Blender goes on meanwhile"""
    bl_idname = "hm.bake"
    bl_label = "Bake"
    kind = "bake"

    def job(self, scene, settings):
        scan, model = path_of(settings, "scan"), path_of(settings, "model")
        if not scan and scan_object.is_scan(bpy.context.object):
            scan = bpy.context.object[scan_object.SCAN]
        if scan and not model:
            model = os.path.splitext(scan)[0] + ".model"
            settings.model = model
        return tools.bake(preferences.find(PROGRAM), scan, path_of(settings, "regions"), model, settings.size_px,
                          settings.delight)


class HM_OT_show_model(Operator):
    """Put the baked model into the scene, with its maps on it"""
    bl_idname = "hm.show_model"
    bl_label = "Show Maps"
    bl_options = {"REGISTER", "UNDO"}

    def run(self, context):
        item = baked.show(context.scene, tools.expect(path_of(context.scene.hm.tools, "model"), "Model"))
        for other in context.selected_objects:
            other.select_set(False)
        item.select_set(True)
        context.view_layer.objects.active = item
        return "%s: %d triangles, %d texture sets" % (item.name, len(item.data.polygons), len(item.data.materials))


class HM_OT_produce(ToolOperator):
    """Make the plan's dataset. What is there already is kept; after Cancel the same button goes on"""
    bl_idname = "hm.produce"
    bl_label = "Produce"
    kind = "produce"

    def job(self, scene, settings):
        return tools.produce(preferences.find(PROGRAM), path_of(settings, "plan"), path_of(settings, "dataset"),
                             settings.workers)


class HM_OT_forecast(ToolOperator):
    """Check the plan, and say from one set how much disk and how many hours all of it takes"""
    bl_idname = "hm.forecast"
    bl_label = "Forecast"
    kind = "produce"

    def job(self, scene, settings):
        return tools.forecast(preferences.find(PROGRAM), path_of(settings, "plan"))


class HM_OT_show_samples(ToolOperator):
    """Gather thumbnails of the dataset, beside it, and show them as an image"""
    bl_idname = "hm.show_samples"
    bl_label = "Show Samples"
    kind = "produce"

    def job(self, scene, settings):
        return tools.page(preferences.find(PROGRAM), path_of(settings, "dataset"), show_sheet)


def show_sheet(folder):
    """The contact sheet as an image of the .blend, in an Image Editor where one is open."""
    path = os.path.join(folder, "contact_sheet.png")
    if not os.path.isfile(path):
        raise InputError(path, "", "was not written", "choose the program of the add-on's version")
    image = bpy.data.images.load(path, check_existing=True)
    image.reload()
    image.preview_ensure()
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "IMAGE_EDITOR":
                area.spaces.active.image = image
    return "Samples: image %s, %d x %d" % (image.name, *image.size)


def sheet(settings):
    """The image of show_sheet, or None."""
    path = os.path.join(tools.page_of(path_of(settings, "dataset")), "contact_sheet.png")
    return next((i for i in bpy.data.images if i.filepath and bpy.path.abspath(i.filepath) == path), None)


class HM_OT_validate(ToolOperator):
    """Render one view in Cycles and by the project's own renderer and say whether they agree"""
    bl_idname = "hm.validate"
    bl_label = "Compare With Cycles"
    kind = "validate"

    def job(self, scene, settings):
        light = path_of(settings, "environment") or environment.path_of(scene)
        blender, model = path_of(settings, "blender"), compat.validated_model()
        if not blender and model:
            blender = bpy.app.binary_path
        if not path_of(settings, "report") and path_of(settings, "model"):
            settings.report = path_of(settings, "model") + ".report"
        return tools.validate(
            preferences.find(PROGRAM), path_of(settings, "model"), light, path_of(settings, "report"),
            {"view": "%d/360" % settings.turn_deg, "size": settings.view_px, "spp": settings.spp,
             "seeds": settings.seeds, "model": model or "v1", "blender": blender})


class HM_OT_open_page(bpy.types.Operator):
    """Open the page in the browser"""
    bl_idname = "hm.open_page"
    bl_label = "Open Page"
    path: bpy.props.StringProperty(options={"HIDDEN"})

    def execute(self, context):
        if not os.path.isfile(self.path):
            self.report({"ERROR"}, "%s: is not there; make it again" % self.path)
            return {"CANCELLED"}
        bpy.ops.wm.url_open(url=pathlib.Path(self.path).as_uri())
        return {"FINISHED"}


class HM_OT_open_cycles_scene(Operator):
    """Open the scene as Cycles rendered it, in another Blender: this one stays as it is"""
    bl_idname = "hm.open_cycles_scene"
    bl_label = "Open Cycles' Scene"

    def run(self, context):
        settings = context.scene.hm.tools
        path = os.path.join(path_of(settings, "report"), "scene.blend")
        tools.expect(path, "Cycles' scene", os.path.isfile)
        program = path_of(settings, "blender") or bpy.app.binary_path
        if not program:
            raise InputError(path, "", "this Blender is a module without a window", "open it in Blender")
        subprocess.Popen([program, path], stdin=subprocess.DEVNULL, start_new_session=True)
        return "Opening %s" % path


CLASSES = (HM_OT_bake, HM_OT_show_model, HM_OT_produce, HM_OT_forecast, HM_OT_show_samples, HM_OT_validate,
           HM_OT_open_page, HM_OT_open_cycles_scene)
