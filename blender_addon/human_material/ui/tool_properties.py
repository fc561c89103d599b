# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of the panels Bake, Produce and Validate (scene.hm.tools)."""
import bpy
from bpy.props import BoolProperty, IntProperty, StringProperty

from .. import compat


def _path(name, subtype, description):
    return StringProperty(name=name, subtype=subtype, description=description, options=compat.path_options())


class HM_PG_tools(bpy.types.PropertyGroup):
    scan: _path("Scan", "FILE_PATH", "Mesh that was labelled. Save Regions fills it in")
    regions: _path("Regions", "DIR_PATH", "Folder that Save Regions wrote for this scan")
    size_px: IntProperty(name="Size (px)", default=0, min=0, max=8192, subtype="NONE",
                         description="Texels along the longer edge of the maps; 0: as many as the scan's picture has")
    delight: BoolProperty(name="Delight", default=False,
                          description="Divide the scan's pictures by the light of their surroundings")
    model: _path("Model", "DIR_PATH", "Folder of the baked model: Bake writes it, Validate reads it")
    plan: _path("Plan", "FILE_PATH", "plan.xml: who, which views, which lights")
    dataset: _path("Dataset", "DIR_PATH", "Folder of the dataset")
    workers: IntProperty(name="Workers", default=1, min=1, max=1024, description="People made at once")
    environment: _path("Light", "FILE_PATH", "Latitude-longitude picture; empty: that of the panel Light")
    turn_deg: IntProperty(name="Turn (\u00b0)", default=0, min=0, max=359, subtype="NONE",
                          description="How far the person is turned about the vertical")
    view_px: IntProperty(name="Size (px)", default=256, min=8, max=8192, subtype="NONE", description="Of the pictures")
    spp: IntProperty(name="Paths", default=128, min=1, max=8192, description="Paths a pixel of one picture")
    seeds: IntProperty(name="Pictures", default=8, min=2, max=1024,
                       description="A side, each with its own random numbers; fewer than 8 never pass")
    report: _path("Report", "DIR_PATH", "Folder for the verdict's page")
    blender: _path("Blender", "FILE_PATH", "Blender 3.4 or 4.5; empty: this one, else the one on the PATH")


CLASSES = (HM_PG_tools,)
