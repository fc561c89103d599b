# SPDX-License-Identifier: GPL-3.0-or-later
"""The material of a relief: maps as images of physical values, the edits of each class, the Principled BSDF.

All images are linear floats marked Non-Color, packed into the .blend: the encodings of the files end in
services/maps.py. So the nodes are the same for every maps folder and every Blender.
"""
import bpy

from .. import compat
from . import balance, classes, decode, edit, vector

RADIUS_M = (0.01, 0.002, 0.001)   # of scattering at sss = 1: (1.0, 0.2, 0.1) cm
F0_PER_SPECULAR = 0.08
NODE = "HM_"                      # names of the nodes that other services look for
SUBSURFACE_SCALE = NODE + "SubsurfaceScale"
LEAST_RADIUS = NODE + "LeastRadius"
VISIBLE_PX = 0.5                  # scattering over less than this of a pixel cannot be seen
PRINCIPLED = NODE + "Principled"
BALANCE = NODE + "Balance"


def packed_image(name, width, height, channels):
    """A float image of the given rasters: up to four arrays of equal length, missing ones 0 (alpha 1)."""
    image = bpy.data.images.new(name, width, height, alpha=True, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    image.alpha_mode = "CHANNEL_PACKED"
    values = decode.zeros(4 * width * height)
    values[3::4] = decode.array("f", [1.0]) * (width * height)
    for c, raster in enumerate(channels):
        values[c::4] = raster
    image.pixels.foreach_set(values)
    image.update()
    image.pack()
    return image


def images_of(maps, name):
    """The material's images: HM_diffuse (RGB, alpha = coverage), HM_normal, HM_rss, HM_shares (four classes an image)."""
    width, height = maps.size
    normal = [_encoded(maps.normal[c::3]) for c in range(3)]
    content = {
        "diffuse": [maps.diffuse[c::3] for c in range(3)] + [maps.mask],
        "normal": normal,
        "rss": [maps.roughness, maps.f0, maps.sss],
    }
    every = len(classes.NAMES)
    for first in range(0, every, 4):
        content[_shares_key(first)] = [maps.shares[c::every] for c in range(first, min(first + 4, every))]
    return {key: packed_image("%s %s" % (name, key), width, height, channels)
            for key, channels in content.items()}


def _encoded(values):
    """(n + 1) / 2."""
    if vector.np:
        half = 0.5 * vector.view(values) + 0.5
        return decode.array("f", half.astype("f").tobytes())
    return decode.array("f", [0.5 * n + 0.5 for n in values])


def build(maps, name, subsurface_method="random_walk_skin"):
    """The material of a relief. Its images go with it."""
    material = bpy.data.materials.new(name)
    material[edit.SHARES] = edit.shares_of(maps)
    tree = compat.node_tree_of(material)
    tree.nodes.clear()
    images = images_of(maps, name)
    nodes = {key: texture(tree, key, image, 300 * row)
             for row, (key, image) in enumerate(images.items())}
    rss = _separate(tree, nodes["rss"].outputs["Color"])
    surface = {"base": nodes["diffuse"].outputs["Color"], "roughness": rss[0], "f0": rss[1], "sss": rss[2]}
    surface = edit.add_nodes(tree, surface, _shares(tree, nodes), maps)
    bsdf = _principled(tree, surface, nodes["normal"], subsurface_method)
    _output(tree, bsdf, nodes["diffuse"].outputs["Alpha"])
    compat.set_cut_out(material)
    return material


def texture(tree, key, image, y):
    """The image's node, named after the key."""
    node = tree.nodes.new("ShaderNodeTexImage")
    node.name = node.label = NODE + key
    node.image = image
    node.interpolation = "Linear"
    node.extension = "EXTEND"
    node.location = (-1400, -y)
    return node


def _separate(tree, color):
    node = tree.nodes.new("ShaderNodeSeparateColor")
    node.location = (-1100, -600)
    tree.links.new(color, node.inputs[0])
    return node.outputs


def _shares_key(first):
    """The image of the shares of four classes from the first on."""
    return "shares" if first == 0 else "shares_%d" % first


def _shares(tree, nodes):
    """One output a class."""
    outputs = []
    for first in range(0, len(classes.NAMES), 4):
        texture = nodes[_shares_key(first)]
        parts = _separate(tree, texture.outputs["Color"])
        outputs += [parts[0], parts[1], parts[2], texture.outputs["Alpha"]]
    return outputs


def math_node(tree, operation, *values, name=""):
    """A Math node; values are outputs or numbers. Returns its output."""
    node = tree.nodes.new("ShaderNodeMath")
    node.operation = operation
    if name:
        node.name = node.label = name
    for i, value in enumerate(values):
        if isinstance(value, (int, float)):
            node.inputs[i].default_value = value
        else:
            tree.links.new(value, node.inputs[i])
    return node.outputs[0]


def _principled(tree, surface, normal_texture, subsurface_method):
    node = tree.nodes.new("ShaderNodeBsdfPrincipled")
    node.name = PRINCIPLED
    node.location = (300, 0)
    compat.prepare_principled(node)
    compat.set_subsurface_method(node, subsurface_method)
    specular = math_node(tree, "DIVIDE", surface["f0"], F0_PER_SPECULAR)
    scale = _scattering(tree, surface["sss"])
    normal = _normal(tree, normal_texture)
    base = surface["base"]
    if compat.generation() == "principled_v2":
        base = _balanced(tree, surface, normal)
    for meaning, output in (("base", base), ("subsurface_color", surface["base"]),
                            ("roughness", surface["roughness"]), ("specular", specular),
                            ("subsurface_scale", scale), ("normal", normal)):
        target = compat.principled_socket(node, meaning)
        if target is not None:
            tree.links.new(output, target)
    compat.principled_socket(node, "subsurface_radius").default_value = RADIUS_M
    return node


def _balanced(tree, surface, normal):
    """The albedo times balance.gain()."""
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = bpy.data.node_groups.get(BALANCE) or _balance_group()
    node.name = node.label = BALANCE
    node.location = (100, 200)
    for name, output in (("Base", surface["base"]), ("Roughness", surface["roughness"]), ("F0", surface["f0"]),
                         ("Normal", normal)):
        tree.links.new(output, node.inputs[name])
    return node.outputs["Base"]


def _balance_group():
    tree = bpy.data.node_groups.new(BALANCE, "ShaderNodeTree")
    for name, kind in (("Base", "Color"), ("Roughness", "Float"), ("F0", "Float"), ("Normal", "Vector")):
        compat.new_group_socket(tree, name, "INPUT", "NodeSocket" + kind)
    compat.new_group_socket(tree, "Base", "OUTPUT", "NodeSocketColor")
    source = tree.nodes.new("NodeGroupInput").outputs
    angle = tree.nodes.new("ShaderNodeLayerWeight")
    angle.inputs["Blend"].default_value = 0.5   # Facing = 1 - cosine
    tree.links.new(source["Normal"], angle.inputs["Normal"])

    def with_rim(front, at_rim, power):
        """front + (1 - cosine)^power x a polynomial of the roughness"""
        rim = math_node(tree, "POWER", angle.outputs["Facing"], float(power))
        return math_node(tree, "MULTIPLY_ADD", rim, _polynomial(tree, at_rim, source["Roughness"]), front)
    diffuse = with_rim(_polynomial(tree, balance.DIFFUSE, source["Roughness"]), balance.DIFFUSE_RIM,
                       balance.DIFFUSE_POWER)
    layer = with_rim(source["F0"], balance.LAYER_RIM, balance.LAYER_POWER)
    below = math_node(tree, "SUBTRACT", 1.0, math_node(tree, "MINIMUM", layer, balance.MOST_LAYER))
    gain = tree.nodes.new("ShaderNodeVectorMath")
    gain.operation = "SCALE"
    tree.links.new(source["Base"], gain.inputs[0])
    tree.links.new(math_node(tree, "DIVIDE", diffuse, below), gain.inputs["Scale"])
    tree.links.new(gain.outputs["Vector"], tree.nodes.new("NodeGroupOutput").inputs["Base"])
    return tree


def _polynomial(tree, coefficients, x):
    value = coefficients[-1]
    for coefficient in reversed(coefficients[:-1]):
        value = math_node(tree, "MULTIPLY_ADD", value, x, coefficient)
    return value


def _scattering(tree, sss):
    """The subsurface map times the factor of SUBSURFACE_SCALE; 0, which Cycles takes as diffuse, where the map says
    that there is none, and where light scatters over less than LEAST_RADIUS cm."""
    scaled = math_node(tree, "MULTIPLY", sss, 1.0, name=SUBSURFACE_SCALE)
    scatters = math_node(tree, "GREATER_THAN", sss, classes.LEAST_SSS * (1 - 1e-6))
    is_seen = math_node(tree, "GREATER_THAN", scaled, 0.0, name=LEAST_RADIUS)
    return math_node(tree, "MULTIPLY", scaled, math_node(tree, "MULTIPLY", scatters, is_seen))


def _normal(tree, texture):
    """Object space, whose axes are the camera's: exact under any turn of the object."""
    node = tree.nodes.new("ShaderNodeNormalMap")
    node.space = "OBJECT"
    node.location = (0, -500)
    tree.links.new(texture.outputs["Color"], node.inputs["Color"])
    return node.outputs["Normal"]


def _output(tree, bsdf, alpha):
    clear = tree.nodes.new("ShaderNodeBsdfTransparent")
    mix = tree.nodes.new("ShaderNodeMixShader")
    mix.location = (600, 0)
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    output.location = (800, 0)
    tree.links.new(alpha, mix.inputs[0])
    tree.links.new(clear.outputs[0], mix.inputs[1])
    tree.links.new(bsdf.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], output.inputs["Surface"])


def build_rear(skin, name):
    """Of the back: throws shadows and light, and is never seen: the camera looks through it."""
    material = bpy.data.materials.new(name + " back")
    tree = compat.node_tree_of(material)
    tree.nodes.clear()
    color = texture(tree, "rear", skin.node_tree.nodes[NODE + "diffuse"].image, 0)
    diffuse = tree.nodes.new("ShaderNodeBsdfDiffuse")
    tree.links.new(color.outputs["Color"], diffuse.inputs["Color"])
    clear = tree.nodes.new("ShaderNodeBsdfTransparent")
    mix = tree.nodes.new("ShaderNodeMixShader")
    tree.links.new(tree.nodes.new("ShaderNodeLightPath").outputs["Is Camera Ray"], mix.inputs[0])
    tree.links.new(diffuse.outputs[0], mix.inputs[1])
    tree.links.new(clear.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    compat.set_cut_out(material)
    return material


def set_subsurface_scale(material, factor):
    """Multiplies the subsurface map; 0 turns subsurface scattering off."""
    material.node_tree.nodes[SUBSURFACE_SCALE].inputs[1].default_value = factor


def set_visible_scattering(material, pixel_cm):
    """Light scatters only where it is seen to, in a picture with pixels of that width; 0: wherever the map says. A
    walk that ends in the pixel where it began only adds noise."""
    material.node_tree.nodes[LEAST_RADIUS].inputs[1].default_value = VISIBLE_PX * pixel_cm


TEXTURES = ("diffuse", "normal", "rss", "shares")


def set_interpolation(material, smooth):
    """Smooth between the maps' pixels, or each texel as it is: all but the normals, which turn within a pixel too; at
    the outline they end up looking sideways, and light from behind gets there."""
    for key in TEXTURES:
        is_linear = smooth or key == "normal"
        material.node_tree.nodes[NODE + key].interpolation = "Linear" if is_linear else "Closest"


def is_ours(material):
    return (material is not None and material.node_tree is not None
            and SUBSURFACE_SCALE in material.node_tree.nodes)
