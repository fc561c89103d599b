# SPDX-License-Identifier: GPL-3.0-or-later
"""The photograph behind the person: in the camera's view, and under the rendered picture; and the ground that catches
the person's shadow."""
import os

import bpy
from mathutils import Vector

from .. import compat
from . import camera, grid
from .errors import InputError

CATCHER = "hm_catcher"
NAME = "HM Ground"
NODE = "HM Plate"


def load(path, scene):
    """The photograph. Raises InputError if it is none, or not of the picture's shape."""
    if not os.path.isfile(path):
        raise InputError(path, "", "there is no such file", "choose the photograph that the maps belong to")
    try:
        image = bpy.data.images.load(path, check_existing=True)
    except RuntimeError as error:
        raise InputError(path, "", "cannot be opened (%s)" % str(error).strip(), "choose a picture") from None
    width, height = image.size
    cause = ""
    if width == 0 or height == 0:
        cause = "cannot be decoded"
    elif abs(width * scene.render.resolution_y / (height * scene.render.resolution_x) - 1) > 0.01:
        cause = "is %d x %d, the scene's picture %d x %d" % (width, height, scene.render.resolution_x,
                                                             scene.render.resolution_y)
    if not cause:
        return image
    if image.users == 0:
        bpy.data.images.remove(image)
    raise InputError(path, "", cause, "choose the photograph that the maps belong to")


def set_plate(scene, path):
    """Shows the photograph behind the matched camera, and puts it under rendered pictures. Gives the image."""
    if scene.camera is None or not scene.camera.name.startswith(camera.NAME):
        raise InputError("", "", "the camera is not the photograph's", "press Match Camera first")
    image = load(path, scene)
    lens = scene.camera.data
    lens.show_background_images = True
    for old in [b for b in lens.background_images if b.image is None or b.image.get(NODE)]:
        lens.background_images.remove(old)
    background = lens.background_images.new()
    background.image, background.alpha, background.frame_method = image, 1.0, "STRETCH"
    image[NODE] = True
    scene.render.film_transparent = True
    compat.composite_over(scene, image, NODE)
    return image


def remove_plate(scene):
    """The compositor and the camera as before; nodes of others stay."""
    compat.remove_composite(scene, NODE)
    if scene.camera is not None and scene.camera.type == "CAMERA":
        for old in [b for b in scene.camera.data.background_images if b.image is not None and b.image.get(NODE)]:
            scene.camera.data.background_images.remove(old)


def add_ground(scene, item, size_m=4.0):
    """A plane under the person that is seen only by its shadow. Stands where the soles are: at Z = 0, or at the lowest
    point of a picture that does not show them."""
    for old in [o for o in scene.objects if CATCHER in o]:
        mesh = old.data
        bpy.data.objects.remove(old)
        bpy.data.meshes.remove(mesh)
    lowest = min((item.matrix_world @ Vector(corner)).z for corner in item.bound_box)
    z = 0.0 if abs(lowest) < 5 * grid.CM else lowest
    mesh = bpy.data.meshes.new(NAME)
    half = size_m / 2
    mesh.from_pydata([(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)], [], [(0, 1, 2, 3)])
    ground = bpy.data.objects.new(NAME, mesh)
    place = item.matrix_world.translation
    ground.location = (place.x, place.y, z)
    ground[CATCHER] = True
    compat.set_shadow_catcher(ground)
    scene.collection.objects.link(ground)
    return ground
