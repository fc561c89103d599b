# SPDX-License-Identifier: GPL-3.0-or-later
"""Sidebar tab "Human Material": Maps, Light, Edit, Render."""
import bpy

from .. import compat
from ..services import classes, edit, environment, presets, relief
from ..services.errors import InputError


class Panel:
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Human Material"

    def prepared(self):
        self.layout.use_property_split = True
        self.layout.use_property_decorate = False
        return self.layout


class HM_PT_maps(Panel, bpy.types.Panel):
    bl_label = "Maps"

    def draw(self, context):
        layout = self.prepared()
        layout.operator("hm.import_maps", icon="IMPORT")
        settings = context.scene.hm
        layout.prop(settings, "jump_cm", text="Cut (cm)")
        layout.prop(settings, "subsurface_method", text="Scatter")
        layout.prop(settings, "subsurface_scale", text="Scale")
        layout.prop(settings, "scatter_everywhere")
        if relief.is_relief(context.object):
            shape = context.object["hm_camera"]
            layout.label(text="%s: %d x %d" % (context.object.name, shape["width_px"], shape["height_px"]))
            layout.label(text=context.object[relief.PROPERTY], icon="FILE_FOLDER")
        layout.operator("hm.match_camera", icon="CAMERA_DATA")


class HM_PT_light(Panel, bpy.types.Panel):
    bl_label = "Light"

    def draw(self, context):
        layout = self.prepared()
        settings = context.scene.hm
        layout.template_icon_view(settings, "environment_file", show_labels=True, scale=4)
        layout.operator("hm.set_environment", icon="WORLD")
        if environment.has_world(context.scene):
            image = context.scene.world.node_tree.nodes[environment.TEXTURE].image
            try:
                environment.check_present(context.scene)
                layout.label(text=image.name if image else "No environment")
            except InputError:
                layout.label(text="%s is missing" % image.name, icon="ERROR")
        column = layout.column()
        column.prop(settings, "rotation_deg", text="Rotation (°)")
        column.operator("hm.rotate_light", icon="FILE_REFRESH")
        column.prop(settings, "strength")
        column.prop(settings, "show_background", text="Visible")
        column = layout.column()
        for axis, name in enumerate(("Right (cm)", "Up (cm)", "Near (cm)")):
            column.prop(settings, "point_cm", index=axis, text=name)
        column.prop(settings, "point_intensity", text="At 1 m")
        column.operator("hm.add_point_light", icon="LIGHT_POINT")


class HM_PT_edit(Panel, bpy.types.Panel):
    bl_label = "Edit"

    def draw(self, context):
        if relief.material_of(context.object) is None:
            self.layout.label(text="Select an imported person")
        else:
            self.layout.operator("hm.edit_garment", icon="EYEDROPPER")


def _draw_class(self, context):
    """The presets and sliders of one class, then of its garments that are edited by themselves."""
    skin = relief.material_of(context.object)
    try:
        edit.expect_present(skin, self.class_name)
    except InputError:
        self.layout.label(text="None on this person", icon="INFO")
        return
    _draw_edit(self.layout, self.class_name, edit.node_of(skin, self.class_name))
    for key, node in sorted(edit.nodes_of(skin).items()):
        if key.startswith(self.class_name + "."):
            box = self.layout.box()
            box.label(text="Garment " + key.partition(".")[2])
            _draw_edit(box, self.class_name, node, int(key.partition(".")[2]))


def _draw_edit(layout, class_name, node, garment=0):
    """The names stand inside the sliders: beside them they are cut off."""
    row = layout.row(align=True)
    row.context_pointer_set("hm_edit", node)
    row.menu("HM_MT_presets_" + class_name, text="Preset")
    button = row.operator("hm.reset_edit", icon="LOOP_BACK")
    button.class_name, button.garment = class_name, garment
    column = layout.column(align=True)
    column.prop(node.inputs["Color"], "default_value", text="Color")
    for name in edit.SLIDERS:
        column.prop(node.inputs[name], "default_value", text=name, slider=True)


def _draw_presets(self, context):
    node = getattr(context, "hm_edit", None)   # whose menu it is
    garment = node.name.rpartition(".")[2] if node is not None and "." in node.name else "0"
    for preset in presets.of_class(self.class_name):
        button = self.layout.operator("hm.apply_preset", text=preset.label)
        button.class_name, button.preset, button.garment = self.class_name, preset.name, int(garment)


def _preset_menu(entry):
    """The presets of one class."""
    return type("HM_MT_presets_" + entry["name"], (bpy.types.Menu,), {
        "bl_label": "Preset", "bl_idname": "HM_MT_presets_" + entry["name"], "class_name": entry["name"],
        "draw": _draw_presets})


def _class_panel(entry):
    """One sub-panel of Edit a class."""
    return type("HM_PT_edit_" + entry["name"], (Panel, bpy.types.Panel), {
        "bl_label": entry["label"], "bl_parent_id": "HM_PT_edit", "bl_options": {"DEFAULT_CLOSED"},
        "class_name": entry["name"], "draw": _draw_class,
        "poll": classmethod(lambda cls, context: relief.material_of(context.object) is not None)})


class HM_PT_render(Panel, bpy.types.Panel):
    bl_label = "Render"

    def draw(self, context):
        layout = self.prepared()
        layout.prop(context.scene.hm, "samples", text="Final")
        layout.prop(context.scene.hm, "preview_samples", text="Preview")
        if compat.can_denoise():
            layout.prop(context.scene.cycles, "use_denoising", text="Denoise")
            layout.prop(context.scene.cycles, "use_preview_denoising", text="In Preview")
        layout.prop(context.scene.hm, "pixel_exact")
        layout.operator("hm.prepare_render", icon="SCENE")
        layout.operator("hm.render_picture", icon="RENDER_STILL")


CLASSES = (*(_preset_menu(entry) for entry in classes.TABLE), HM_PT_maps, HM_PT_light, HM_PT_edit,
           *(_class_panel(entry) for entry in classes.TABLE), HM_PT_render)
