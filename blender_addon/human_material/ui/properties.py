# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of the panels, kept in the scene (scene.hm)."""
import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, FloatVectorProperty, IntProperty, PointerProperty

from .. import compat
from ..services import camera, environment, material, relief, render
from . import label_properties, thumbnails, tool_properties

SUBSURFACE_ITEMS = (
    ("random_walk_skin", "Random walk for skin", "Least noise, keeps details sharp"),
    ("random_walk_fixed", "Random walk, fixed radius", "Softer; loses light through the open relief"),
    ("burley", "Burley", "Fastest; the same model in every Blender"),
)


def _update_rotation(self, context):
    if environment.has_world(context.scene):
        environment.set_rotation(context.scene, self.rotation_deg)


def _update_strength(self, context):
    if environment.has_world(context.scene):
        environment.set_strength(context.scene, self.strength)


def _update_background(self, context):
    environment.show_background(context.scene, self.show_background)


def _update_subsurface(self, context):
    for item in relief.reliefs(context.scene):
        found = relief.material_of(item)
        if found:
            material.set_subsurface_scale(found, self.subsurface_scale)
            shape = item[camera.PROPERTY]
            pixel_cm = camera.frame_width_cm(shape) / shape["width_px"]
            material.set_visible_scattering(found, 0 if self.scatter_everywhere else pixel_cm)
            compat.set_subsurface_method(found.node_tree.nodes[material.PRINCIPLED], self.subsurface_method)


def _update_pixel_exact(self, context):
    for item in relief.reliefs(context.scene):
        found = relief.material_of(item)
        if found:
            render.set_pixel_exact(context.scene, found, self.pixel_exact)


def _update_samples(self, context):
    if context.scene.render.engine == "CYCLES":
        context.scene.cycles.samples = self.samples
        context.scene.cycles.preview_samples = self.preview_samples


def _update_environment(self, context):
    if self.environment_file and self.environment_file != environment.path_of(context.scene):
        bpy.ops.hm.set_environment("EXEC_DEFAULT", filepath=self.environment_file)


class HM_PG_scene(bpy.types.PropertyGroup):
    jump_cm: FloatProperty(
        name="Depth Cut (cm)", default=5.0, min=0.1, soft_max=50, subtype="NONE",
        description="Depth difference of neighbouring pixels in cm above which the surface is cut")
    rotation_deg: FloatProperty(
        name="Rotation (deg)", default=0.0, soft_min=-180, soft_max=180, update=_update_rotation,
        description="Turns the environment about the vertical, in degrees: after 90, light that came from the "
                    "viewer comes from the picture's right")
    strength: FloatProperty(name="Strength", default=1.0, min=0.0, soft_max=5, update=_update_strength,
                            description="Factor on the environment's light")
    show_background: BoolProperty(name="Show Environment", default=False, update=_update_background,
                                  description="Show the environment behind the person; else transparent")
    subsurface_scale: FloatProperty(name="Subsurface Scale", default=1.0, min=0.0, soft_max=5,
                                    update=_update_subsurface,
                                    description="Factor on the subsurface map; 0 turns scattering off")
    scatter_everywhere: BoolProperty(
        name="Unseen Too", default=False, update=_update_subsurface,
        description="Scatter light also where it goes less than half a pixel of the maps: for views from nearer by. "
                    "It costs noise")
    subsurface_method: EnumProperty(name="Subsurface Method", items=SUBSURFACE_ITEMS, default="random_walk_skin",
                                    update=_update_subsurface)
    point_cm: FloatVectorProperty(
        name="Position (cm)", size=3, subtype="NONE", default=(100.0, 220.0, 200.0),
        description="Where a new point light goes, in cm: right, up from the ground, towards the viewer")
    point_intensity: FloatProperty(name="Intensity", default=5.0, min=0.0, soft_max=20,
                                   description="Irradiance of a new point light at 1 m")
    pixel_exact: BoolProperty(
        name="Pixel Exact", default=True, update=_update_pixel_exact,
        description="Each pixel of the picture is one of the maps, for the matched camera at the maps' size. Turn off "
                    "for other views and sizes: then the maps are interpolated")
    samples: IntProperty(name="Final Samples", default=64, min=1, soft_max=1024, update=_update_samples,
                         description="Samples a pixel of the picture")
    environment_file: EnumProperty(name="Environment", items=thumbnails.items, update=_update_environment,
                                   options={"SKIP_SAVE"}, description="Used last, and of the preferences' folder")
    label: PointerProperty(type=label_properties.HM_PG_label)
    tools: PointerProperty(type=tool_properties.HM_PG_tools)
    preview_samples: IntProperty(name="Preview Samples", default=16, min=1, soft_max=256, update=_update_samples,
                                 description="Samples a pixel in the viewport")


CLASSES = (HM_PG_scene,)
