# SPDX-License-Identifier: GPL-3.0-or-later
"""The world as a latitude-longitude environment in this project's convention.

Our axes: u = 1/2 + atan2(z, x) / 2 pi from the left, the image's centre is +X, +Z (to the viewer) is at u = 3/4, the
top row is +Y. In Blender's axes that is Cycles' own mapping. A rotation of d degrees turns the environment about +Y,
right-handed: light from +Z comes from +X after 90 degrees. It is the sense in which the subject of a sample turns,
so turning the subject by a and the environment by -a look alike to the subject's front.
"""
import math
import os

import bpy

from .. import compat
from .errors import InputError

NAME = "HM World"
TEXTURE, MAPPING, BACKGROUND = "HM_Environment", "HM_Mapping", "HM_Background"
MIN_IMPORTANCE_PX, MAX_IMPORTANCE_PX = 256, 4096   # width of the table by which light is sampled


def load_picture(path):
    """The environment's image, linear floats. Throws InputError, and then leaves nothing behind."""
    if not os.path.isfile(path):
        raise InputError(path, "", "there is no such file", "choose a latitude-longitude picture (EXR or HDR)")
    try:
        image = bpy.data.images.load(path, check_existing=False)
    except RuntimeError as error:
        raise InputError(path, "", "cannot be opened (%s)" % error, "choose an EXR or HDR picture") from None
    width, height = image.size
    if width == 0 or height == 0:
        cause = "cannot be decoded", "choose a single-part EXR or an HDR picture"
    elif width != 2 * height:
        cause = "is %d x %d, not twice as wide as high" % (width, height), "use a latitude-longitude map"
    elif not image.is_float:
        cause = "has 8 bits a channel", "use a linear EXR or HDR picture"
    else:
        return image
    bpy.data.images.remove(image)
    raise InputError(path, "", *cause)


def set_environment(scene, path, rotation_deg=0.0, strength=1.0):
    """Lights the scene by an environment. Throws InputError before anything is changed."""
    image = load_picture(path)
    nodes = world_nodes(scene)
    old = nodes[TEXTURE].image
    nodes[TEXTURE].image = image
    if old is not None and old.users == 0:
        bpy.data.images.remove(old)
    set_rotation(scene, rotation_deg)
    set_strength(scene, strength)
    # Cycles' automatic importance map has millions of points (5 s) for the smallest picture.
    scene.world.cycles.sampling_method = "MANUAL"
    scene.world.cycles.sample_map_resolution = min(MAX_IMPORTANCE_PX, max(MIN_IMPORTANCE_PX, 2 * image.size[0]))
    return image


def set_rotation(scene, rotation_deg):
    """Cycles looks up the turned direction: the environment itself turns the other way."""
    nodes = world_nodes(scene)
    nodes[MAPPING].inputs["Rotation"].default_value = (0, 0, -math.radians(rotation_deg))


def set_strength(scene, strength):
    world_nodes(scene)[BACKGROUND].inputs["Strength"].default_value = strength


def check_present(scene):
    """Throws InputError if the environment's file has gone since it was chosen: the world would be pink."""
    if not has_world(scene):
        return
    image = scene.world.node_tree.nodes[TEXTURE].image
    if image is None or image.packed_file is not None or image.source != "FILE":
        return
    path = bpy.path.abspath(image.filepath)
    if not os.path.isfile(path):
        raise InputError(path, "", "the environment is not there any more", "choose it again (Environment)")


def path_of(scene):
    """The environment's file, or ""."""
    image = scene.world.node_tree.nodes[TEXTURE].image if has_world(scene) else None
    return os.path.abspath(bpy.path.abspath(image.filepath)) if image is not None else ""


def set_dark(scene):
    """No environment: other lights only."""
    nodes = world_nodes(scene)
    nodes[TEXTURE].image = None
    set_strength(scene, 0)


def show_background(scene, visible):
    """Whether pictures show the environment behind the person, or are transparent there."""
    scene.render.film_transparent = not visible


def world_nodes(scene):
    """Nodes of our world; made and set as the scene's world where it is missing. Other worlds stay."""
    world = scene.world
    if world is None or world.node_tree is None or TEXTURE not in world.node_tree.nodes:
        world = scene.world = _new_world()
    return world.node_tree.nodes


def has_world(scene):
    return scene.world is not None and scene.world.node_tree is not None \
        and TEXTURE in scene.world.node_tree.nodes


def _new_world():
    world = bpy.data.worlds.new(NAME)
    tree = compat.node_tree_of(world)
    tree.nodes.clear()
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    mapping = tree.nodes.new("ShaderNodeMapping")
    mapping.vector_type = "POINT"
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.projection = "EQUIRECTANGULAR"
    texture.interpolation = "Linear"
    background = tree.nodes.new("ShaderNodeBackground")
    output = tree.nodes.new("ShaderNodeOutputWorld")
    for i, (node, name) in enumerate(((coordinates, "HM_Coordinates"), (mapping, MAPPING), (texture, TEXTURE),
                                      (background, BACKGROUND), (output, "HM_Output"))):
        node.name = node.label = name
        node.location = (250 * i - 600, 0)
    tree.links.new(coordinates.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
    tree.links.new(texture.outputs["Color"], background.inputs["Color"])
    tree.links.new(background.outputs[0], output.inputs["Surface"])
    return world
