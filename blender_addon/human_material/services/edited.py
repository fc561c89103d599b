# SPDX-License-Identifier: GPL-3.0-or-later
"""The maps of a person with its edits in them: what the nodes compute, as rasters."""
from . import classes, decode, edit, garment_edit, material


def chain(tree):
    """(key, node) of the edits in the order in which they act."""
    nodes = {node.name: node for node in tree.nodes if node.name.startswith(edit.NODE)}
    node = next(n for n in nodes.values() if n.inputs["Base"].links[0].from_node.name not in nodes)
    while node is not None:
        yield node.name[len(edit.NODE):], node
        node = next((link.to_node for link in node.outputs["Base"].links if link.to_node.name in nodes), None)


def rasters(skin):
    """{"diffuse", "roughness", "f0", "sss", "mask", "normal"} with the edits, row 0 at the bottom, and (width, height).
    diffuse is linear, the normal a unit vector."""
    nodes = skin.node_tree.nodes
    diffuse, shares, width, height = garment_edit.rasters_of(skin)
    rss = garment_edit.raster(nodes[material.NODE + "rss"].image, 3)
    coded = garment_edit.raster(nodes[material.NODE + "normal"].image, 3)
    maps = {"diffuse": diffuse, "roughness": rss[0::3], "f0": rss[1::3], "sss": rss[2::3],
            "mask": garment_edit.raster(nodes[material.NODE + "diffuse"].image, 4)[3::4],
            "normal": decode.array("f", [2 * value - 1 for value in coded])}
    for key, node in chain(skin.node_tree):
        _apply(maps, _weights(skin, shares, key), node)
    return maps, (width, height)


def _weights(skin, shares, key):
    """(pixel, share) where an edit acts."""
    every, c = len(classes.NAMES), classes.NAMES.index(edit.class_of(key))
    number = int(key.partition(".")[2] or 0)
    numbers = garment_edit.numbers_of(skin)[0] if number else None
    for p, share in enumerate(shares[c::every]):
        if share > 0 and (numbers is None or numbers[p] == number):
            yield p, share


def _apply(maps, weights, node):
    value = {name: node.inputs[name].default_value for name in edit.SLIDERS}
    color, mean = node.inputs["Color"].default_value, node.inputs["Mean Luminance"].default_value
    steps = [(name, value[amount], value[slider]) for name, amount, slider in (
        ("roughness", "Roughness Amount", "Roughness"), ("f0", "Specular Amount", "F0"),
        ("sss", "Subsurface Amount", "Subsurface")) if value[amount] > 0]
    recolour, diffuse = value["Color Amount"], maps["diffuse"]
    if not steps and recolour == 0:
        return
    for p, share in weights:
        for name, amount, target in steps:
            maps[name][p] += share * amount * (target - maps[name][p])
        if recolour > 0:
            gain = decode.luminance(*diffuse[3 * p:3 * p + 3]) / mean
            for c in range(3):
                diffuse[3 * p + c] += share * recolour * (min(color[c] * gain, 1.0) - diffuse[3 * p + c])
