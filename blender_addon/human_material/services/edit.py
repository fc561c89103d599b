# SPDX-License-Identifier: GPL-3.0-or-later
"""Edits of one class: its colour and its material, by a chain of node groups that leave the rest alone.

The group HM_ClassEdit computes out = in + share x amount x (target - in) for each quantity. The colour's target is
color x luminance / mean luminance of the class: light and dark of the texture stay. Sliders are the group's inputs, so
the nodes are the only place where an edit is kept.
"""
import bpy

from .. import compat
from . import classes, decode, presets, vector
from .errors import InputError

GROUP = "HM_ClassEdit"
NODE = "HM_Edit_"
DARK = 0.002   # mean luminance below which a class is taken as this bright

#: slider of the group -> (quantity, lowest, highest)
SLIDERS = {
    "Color Amount": ("base", 0, 1),
    "Roughness Amount": ("roughness", 0, 1),
    "Roughness": ("roughness", 0, 1),
    "Specular Amount": ("f0", 0, 1),
    "F0": ("f0", 0, 0.2),
    "Subsurface Amount": ("sss", 0, 1),
    "Subsurface": ("sss", 0, 1),
}


def add_nodes(tree, surface, shares, maps):
    """Links one group a class behind another; returns the edited surface."""
    group = _group()
    for c, name in enumerate(classes.NAMES):
        node = tree.nodes.new("ShaderNodeGroup")
        node.node_tree = group
        node.name = NODE + name
        node.label = "Edit " + name
        node.location = (-800 + 220 * c, 0)
        for key, socket in (("base", "Base"), ("roughness", "Roughness In"), ("f0", "F0 In"),
                            ("sss", "Subsurface In")):
            tree.links.new(surface[key], node.inputs[socket])
        tree.links.new(shares[c], node.inputs["Share"])
        node.inputs["Mean Luminance"].default_value = max(DARK, mean_luminance(maps, c))
        reset_node(node, c)
        surface = {"base": node.outputs["Base"], "roughness": node.outputs["Roughness"],
                   "f0": node.outputs["F0"], "sss": node.outputs["Subsurface"]}
    return surface


def mean_luminance(maps, class_index):
    """Of the class's albedo, weighted by its share and coverage."""
    total = weight_sum = 0.0
    shares, mask, diffuse = maps.shares, maps.mask, maps.diffuse
    if vector.np:
        weights = vector.view(shares, len(classes.NAMES))[:, class_index].astype(float) * vector.view(mask)
        weight_sum = weights.sum()
        lit = vector.view(diffuse, 3).astype(float) @ [0.2126, 0.7152, 0.0722]
        return float((weights * vector.np.where(weights > 0, lit, 0)).sum() / weight_sum) if weight_sum > 0 else 0.0
    for p in range(len(mask)):
        weight = shares[len(classes.NAMES) * p + class_index] * mask[p]
        if weight > 0:
            total += weight * decode.luminance(diffuse[3 * p], diffuse[3 * p + 1], diffuse[3 * p + 2])
            weight_sum += weight
    return total / weight_sum if weight_sum > 0 else 0.0


def class_of(key):
    """The class of an edit: its own name, or "fabric" of "fabric.3", a garment's."""
    return key.partition(".")[0]


def node_of(material, key):
    """The edit node of a class or garment. Throws InputError for an unknown one or a foreign material."""
    class_name = class_of(key)
    if class_name not in classes.NAMES:
        raise InputError("", "class '%s'" % class_name, "is not known", "write " + ", ".join(classes.NAMES))
    node = material.node_tree.nodes.get(NODE + key) if material and material.node_tree else None
    if node is None:
        raise InputError("", material.name if material else "no material", "is not a material of imported maps",
                         "select the relief of an imported maps folder")
    return node


def nodes_of(material):
    """Class or garment -> edit node, of a material of ours; none of another."""
    if material is None or material.node_tree is None:
        return {}
    return {node.name[len(NODE):]: node for node in material.node_tree.nodes if node.name.startswith(NODE)}


SHARES = "hm_class_shares"   # custom property of the material: of the person, one a class


def expect_present(material, class_name):
    """Throws InputError if the person has nothing of a class: an edit would change nothing."""
    shares = material.get(SHARES) if material else None
    if shares is not None and shares[classes.NAMES.index(class_name)] < LEAST_SHARE:
        there = [name for name, share in zip(classes.NAMES, shares) if share >= LEAST_SHARE]
        raise InputError("", material.name, "no %s was found on this person: the edit would change nothing"
                         % class_name, "edit " + " or ".join(there))


LEAST_SHARE = 1e-4


def shares_of(maps):
    """How much of the person each class is."""
    every = len(classes.NAMES)
    totals = [sum(maps.shares[c::every]) for c in range(every)]
    return [total / max(sum(totals), 1e-9) for total in totals]


def apply(material, key, preset):
    """Applies a presets.Preset to a class or garment; what the preset does not name is left as it is."""
    node = node_of(material, key)
    if preset.color is not None:
        node.inputs["Color"].default_value = (*preset.color, 1.0)
        node.inputs["Color Amount"].default_value = 1.0
    for slider, amount, value in (("Roughness", "Roughness Amount", preset.roughness),
                                  ("F0", "Specular Amount", preset.f0),
                                  ("Subsurface", "Subsurface Amount", preset.sss)):
        if value is not None:
            node.inputs[slider].default_value = value
            node.inputs[amount].default_value = 1.0


def reset(material, key):
    reset_node(node_of(material, key), classes.NAMES.index(class_of(key)))


def reset_node(node, class_index):
    """No edit; the sliders stand at the class's own material."""
    for name in SLIDERS:
        if name.endswith("Amount"):
            node.inputs[name].default_value = 0.0
    for name, value in values_as_imported(classes.NAMES[class_index]).items():
        node.inputs[name].default_value = value


def values_as_imported(class_name):
    """Where the sliders of a class stand without an edit, as the floats that Blender keeps."""
    entry = classes.TABLE[classes.NAMES.index(class_name)]
    single = decode.array("f", (entry["roughness"], decode.srgb_to_linear(entry["specular"]), entry["sss"]))
    return {"Color": (0.5, 0.5, 0.5, 1.0), "Roughness": single[0], "F0": single[1], "Subsurface": single[2]}


# The node group -----------------------------------------------------------------------------------------

def _group():
    group = bpy.data.node_groups.get(GROUP)
    return group if group is not None else _new_group()


def _new_group():
    tree = bpy.data.node_groups.new(GROUP, "ShaderNodeTree")
    for name, kind in (("Base", "Color"), ("Roughness In", "Float"), ("F0 In", "Float"),
                       ("Subsurface In", "Float"), ("Share", "Float"), ("Mean Luminance", "Float"),
                       ("Color", "Color")):
        compat.new_group_socket(tree, name, "INPUT", "NodeSocket" + kind)
    for name, (_, low, high) in SLIDERS.items():
        compat.set_socket_range(compat.new_group_socket(tree, name, "INPUT", "NodeSocketFloat"), low, high, 0.0)
    for name, kind in (("Base", "Color"), ("Roughness", "Float"), ("F0", "Float"), ("Subsurface", "Float")):
        compat.new_group_socket(tree, name, "OUTPUT", "NodeSocket" + kind)
    source = tree.nodes.new("NodeGroupInput").outputs
    sink = tree.nodes.new("NodeGroupOutput").inputs
    for quantity, slider, amount in (("Roughness", "Roughness", "Roughness Amount"),
                                     ("F0", "F0", "Specular Amount"),
                                     ("Subsurface", "Subsurface", "Subsurface Amount")):
        weight = _math(tree, "MULTIPLY", source["Share"], source[amount])
        change = _math(tree, "SUBTRACT", source[slider], source[quantity + " In"])
        tree.links.new(_math(tree, "MULTIPLY_ADD", change, weight, source[quantity + " In"]), sink[quantity])
    tree.links.new(_recoloured(tree, source), sink["Base"])
    return tree


def _recoloured(tree, source):
    """base + share x amount x (min(color x luminance / mean, 1) - base)"""
    luminance = tree.nodes.new("ShaderNodeVectorMath")
    luminance.operation = "DOT_PRODUCT"
    luminance.inputs[1].default_value = (0.2126, 0.7152, 0.0722)
    tree.links.new(source["Base"], luminance.inputs[0])
    gain = _math(tree, "DIVIDE", luminance.outputs["Value"], source["Mean Luminance"])
    target = _vector(tree, "MINIMUM", _vector(tree, "SCALE", source["Color"], scale=gain), (1.0, 1.0, 1.0))
    weight = _math(tree, "MULTIPLY", source["Share"], source["Color Amount"])
    change = _vector(tree, "SCALE", _vector(tree, "SUBTRACT", target, source["Base"]), scale=weight)
    return _vector(tree, "ADD", source["Base"], change)


def _math(tree, operation, *inputs):
    node = tree.nodes.new("ShaderNodeMath")
    node.operation = operation
    for i, output in enumerate(inputs):
        tree.links.new(output, node.inputs[i])
    return node.outputs[0]


def _vector(tree, operation, a, b=None, scale=None):
    node = tree.nodes.new("ShaderNodeVectorMath")
    node.operation = operation
    tree.links.new(a, node.inputs[0])
    if isinstance(b, tuple):
        node.inputs[1].default_value = b
    elif b is not None:
        tree.links.new(b, node.inputs[1])
    if scale is not None:
        tree.links.new(scale, node.inputs["Scale"])
    return node.outputs["Vector"]
