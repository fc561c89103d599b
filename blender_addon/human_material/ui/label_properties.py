# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of the label panel (scene.hm.label)."""
import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, StringProperty

from ..services import classes, label_session, scan_object

CLASS_ITEMS = [(entry["name"], entry["label"], "") for entry in classes.TABLE]
MODE_ITEMS = [
    ("BRUSH", "Brush", "Paint a stroke"),
    ("ERASER", "Eraser", "Take away the strokes that the line touches"),
    ("LASSO", "Lasso", "All faces that are seen inside a line"),
    ("MATERIAL", "Material", "All faces of the material that is clicked"),
    ("PIECE", "Piece", "All faces that hang together with the one that is clicked"),
    ("ISLAND", "UV Island", "All faces of the UV island that is clicked"),
]
SHOW_ITEMS = [("PICTURE", "Picture", "The scan's own colours"), ("CLASSES", "Classes", "The class of each face"),
              ("DOUBT", "Doubt", "Orange where the class is a guess")]
UNIT_ITEMS = [("GUESS", "Guessed", "By the height")] + [(u, u, "") for u in ("mm", "cm", "m", "inch", "foot")]
UP_ITEMS = [("Y", "Y", ""), ("Z", "Z", ""), ("X", "X", ""), ("-Y", "-Y", ""), ("-Z", "-Z", ""), ("-X", "-X", "")]


def set_viewports(context, show):
    """The 3D views show the picture or the overlay."""
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                shading = area.spaces.active.shading
                shading.type = "SOLID"
                shading.color_type = "TEXTURE" if show == "PICTURE" else "VERTEX"


def _update_show(self, context):
    for session in label_session.sessions.values():
        session.shown = self.show
        session.set_dirty()
    if scan_object.is_scan(context.object):
        set_viewports(context, self.show)


class HM_PG_label(bpy.types.PropertyGroup):
    mode: EnumProperty(name="Tool", items=MODE_ITEMS, default="BRUSH")
    class_name: EnumProperty(name="Class", items=CLASS_ITEMS, default="skin",
                             description="What the next stroke says that the surface is")
    radius_cm: FloatProperty(name="Radius (cm)", default=1.5, min=0.1, max=50, soft_max=10, precision=1,
                             description="Of the brush on the surface, in cm. Keys [ and ] change it")
    use_pressure: BoolProperty(name="Pressure", default=False,
                               description="A pen's mean pressure makes the radius smaller")
    show: EnumProperty(name="Show", items=SHOW_ITEMS, default="CLASSES", update=_update_show)
    unit: EnumProperty(name="Unit", items=UNIT_ITEMS, default="GUESS", description="Of a scan that is opened")
    up: EnumProperty(name="Up", items=UP_ITEMS, default="Y", description="Which axis of the scan's file points up")
    message: StringProperty(options={"SKIP_SAVE", "HIDDEN"})


CLASSES = (HM_PG_label,)
