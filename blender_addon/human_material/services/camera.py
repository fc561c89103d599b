# SPDX-License-Identifier: GPL-3.0-or-later
"""The camera of maps.json in the scene: rendered at the maps' size it sees the picture that the maps belong to."""
import bpy
from mathutils import Matrix

from . import grid

NAME = "HM Camera"
PROPERTY = "hm_camera"   # custom property of reliefs: the picture's camera and size
STAND_OFF = 10           # orthographic: this many frame widths in front


def remember(item, info):
    """Keeps camera and size at the relief, so that the camera can be matched again later."""
    shape = info.camera
    item[PROPERTY] = {"type": shape.type, "distance_cm": shape.distance_cm, "half_width": shape.half_width,
                      "width_cm": shape.width_cm, "center_y_cm": shape.center_y_cm,
                      "width_px": info.width_px, "height_px": info.height_px}


def frame_width_cm(shape):
    """Of the picture at the centre plane. shape: a relief's PROPERTY."""
    return 2 * shape["distance_cm"] * shape["half_width"] if shape["type"] == "perspective" else shape["width_cm"]


def match(scene, item):
    """Makes the scene's camera and resolution those of the relief's picture. Returns the camera object."""
    shape = item[PROPERTY]
    found = next((c for c in scene.objects if c.type == "CAMERA" and c.name.startswith(NAME)), None)
    if found is None:
        found = bpy.data.objects.new(NAME, bpy.data.cameras.new(NAME))
        scene.collection.objects.link(found)
    lens = found.data
    lens.sensor_fit = "HORIZONTAL"
    lens.shift_x = lens.shift_y = 0
    if shape["type"] == "perspective":
        distance = shape["distance_cm"] * grid.CM
        lens.type = "PERSP"
        lens.lens = lens.sensor_width / 2 / shape["half_width"]
    else:
        lens.type = "ORTHO"
        lens.ortho_scale = shape["width_cm"] * grid.CM * max(1, shape["height_px"] / shape["width_px"])
        lens.sensor_fit = "AUTO"   # ortho_scale is the longer side's
        distance = STAND_OFF * shape["width_cm"] * grid.CM
    lens.clip_start = distance * 1e-3
    lens.clip_end = distance * 100
    # The person's own axes are the camera's: wherever it was moved or turned to, the camera stands before it.
    place = Matrix.LocRotScale(item.matrix_basis.to_translation(), item.matrix_basis.to_quaternion(), None)
    found.matrix_world = place @ Matrix.Translation((0, 0, distance))
    scene.camera = found
    render = scene.render
    render.resolution_x, render.resolution_y = shape["width_px"], shape["height_px"]
    render.resolution_percentage = 100
    render.pixel_aspect_x = render.pixel_aspect_y = 1
    render.use_border = False
    return found
