# SPDX-License-Identifier: GPL-3.0-or-later
"""Files in and out: File > Import and Export, files that are dropped on the window (Blender 4.1 and later), exports."""
import os

import bpy
from bpy.props import StringProperty

from .. import compat
from ..services import export
from .operators import ReliefOperator
from .panels import Panel


class HM_OT_export_maps(ReliefOperator):
    """Write the person with its edits as a new maps folder"""
    bl_idname = "hm.export_maps"
    bl_label = "Export Maps"
    directory: StringProperty(subtype="DIR_PATH", options=compat.path_options())
    folder_name: StringProperty(name="New Folder", default="edited_maps")

    def invoke(self, context, event):
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def run(self, context):
        folder = os.path.join(bpy.path.abspath(self.directory), self.folder_name)
        return "Wrote %s" % export.maps_folder(context.object, folder)


class HM_OT_export_glb(ReliefOperator):
    """Write the person with its edits as a GLB for other programs"""
    bl_idname = "hm.export_glb"
    bl_label = "Export GLB"
    filepath: StringProperty(subtype="FILE_PATH", options=compat.path_options())
    filter_glob: StringProperty(default="*.glb", options={"HIDDEN"})
    check_existing: bpy.props.BoolProperty(default=True, options={"HIDDEN"})

    def invoke(self, context, event):
        self.filepath = self.filepath or context.object.name + ".glb"
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def run(self, context):
        vertices, corners = export.glb(context.object, bpy.path.abspath(self.filepath))
        return "Wrote %d vertices, %d triangles" % (vertices, corners // 3)


class HM_PT_export(Panel, bpy.types.Panel):
    bl_label = "Export"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        column = self.prepared().column(align=True)
        column.operator("hm.export_maps", icon="FILE_FOLDER")
        column.operator("hm.export_glb", icon="EXPORT")


def _import_menu(self, _context):
    self.layout.operator("hm.import_maps", text="Human Material Maps (maps.json)")
    self.layout.operator("hm.open_scan", text="Scan to Label (.obj, .glb, .fbx)")


def _export_menu(self, _context):
    self.layout.operator("hm.export_maps", text="Human Material Maps")
    self.layout.operator("hm.export_glb", text="Human Material Person (.glb)")


def _handler(name, operator, label, extensions):
    return type(name, (bpy.types.FileHandler,), {
        "bl_idname": name, "bl_label": label, "bl_import_operator": operator, "bl_file_extensions": extensions,
        "poll_drop": classmethod(lambda cls, context: context.area is not None and context.area.type == "VIEW_3D")})


HANDLERS = (_handler("HM_FH_maps", "hm.import_maps", "Human Material Maps", ".json"),
            _handler("HM_FH_scan", "hm.open_scan", "Scan to Label", ".obj;.glb;.fbx"),
            _handler("HM_FH_environment", "hm.set_environment", "Environment", ".exr;.hdr")) \
    if hasattr(bpy.types, "FileHandler") else ()

CLASSES = (HM_OT_export_maps, HM_OT_export_glb, HM_PT_export, *HANDLERS)


def register():
    bpy.types.TOPBAR_MT_file_import.append(_import_menu)
    bpy.types.TOPBAR_MT_file_export.append(_export_menu)


def unregister():
    bpy.types.TOPBAR_MT_file_export.remove(_export_menu)
    bpy.types.TOPBAR_MT_file_import.remove(_import_menu)
