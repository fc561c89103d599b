# SPDX-License-Identifier: GPL-3.0-or-later
"""Edits of one garment: a node group like that of a class, behind it, whose share is the class's times a mask of the
garment. Made when a garment is edited first."""
from . import classes, decode, edit, garments, material
from .errors import InputError

IMAGE = material.NODE + "garments"   # its node: red is number / 255 of each pixel's garment
MARK = "."                           # key of a garment's edit: class.number


def raster(image, channels):
    """The first channels of an image of ours."""
    width, height = image.size
    values = decode.zeros(4 * width * height)
    image.pixels.foreach_get(values)
    result = decode.zeros(channels * width * height)
    for c in range(channels):
        result[c::channels] = values[c::4]
    return result


def rasters_of(skin):
    """(diffuse, shares, width, height) that the material was built of."""
    nodes = skin.node_tree.nodes
    image = nodes[material.NODE + "diffuse"].image
    return (raster(image, 3), raster(nodes[material.NODE + "shares"].image, len(classes.NAMES)), *image.size)


def numbers_of(skin):
    """Each pixel's garment (0: none), row 0 at the bottom; found when they are asked for first."""
    node = skin.node_tree.nodes.get(IMAGE)
    if node is None:
        diffuse, shares, width, height = rasters_of(skin)
        numbers, _ = garments.find(diffuse, shares, len(classes.NAMES), width, height)
        red = decode.array("f", [number / 255 for number in garments.grown(numbers, width)])
        node = material.texture(skin.node_tree, "garments", material.packed_image(skin.name + " garments", width,
                                                                                   height, [red]), 2400)
        node.interpolation = "Closest"
    red = raster(node.image, 1)
    return bytearray(int(value * 255 + 0.5) for value in red), *node.image.size


def garment_at(skin, u, v):
    """Number of the garment at a place of the picture, and its class. Raises InputError where there is none."""
    numbers, width, height = numbers_of(skin)
    p = min(int(v * height), height - 1) * width + min(int(u * width), width - 1)
    if not numbers[p]:
        raise InputError("", "", "there is no garment at that place", "click on the person")
    shares = rasters_of(skin)[1]
    return numbers[p], class_of(numbers, shares, numbers[p])


def class_of(numbers, shares, number):
    every = len(classes.NAMES)
    totals = [sum(shares[every * p + c] for p in range(len(numbers)) if numbers[p] == number) for c in range(every)]
    return classes.NAMES[totals.index(max(totals))]


def all_of(skin):
    """[(number, class, pixels)], the largest first."""
    numbers, _, _ = numbers_of(skin)
    shares = rasters_of(skin)[1]
    found = [(number, class_of(numbers, shares, number), numbers.count(number))
             for number in sorted(set(numbers) - {0})]
    return sorted(found, key=lambda one: -one[2])


def node_for(skin, number):
    """The edit node of a garment, made where there is none. Gives (key, node)."""
    numbers, width, height = numbers_of(skin)
    if number not in numbers or number == 0:
        raise InputError("", "garment %d" % number, "is not on this person", "pick one by a click")
    diffuse, shares, _, _ = rasters_of(skin)
    class_name = class_of(numbers, shares, number)
    key = class_name + MARK + str(number)
    found = skin.node_tree.nodes.get(edit.NODE + key)
    if found is None:
        c = classes.NAMES.index(class_name)
        own = bytearray(number if n == number and shares[len(classes.NAMES) * p + c] > 0.5 else 0
                        for p, n in enumerate(numbers))
        found = _insert(skin.node_tree, class_name, key, number)
        found.inputs["Mean Luminance"].default_value = max(edit.DARK, garments.mean_luminance(diffuse, own, number))
        edit.reset_node(found, c)
    return key, found


def _insert(tree, class_name, key, number):
    """Behind the class's own node and what follows it of that class: what it fed is fed by the new one."""
    before = next(node for node in _last_first(tree, class_name))
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = before.node_tree
    node.name, node.label = edit.NODE + key, "Edit " + key
    node.location = (before.location.x + 40, before.location.y - 420)
    for out, into in (("Base", "Base"), ("Roughness", "Roughness In"), ("F0", "F0 In"), ("Subsurface", "Subsurface In")):
        targets = [link.to_socket for link in before.outputs[out].links]
        for target in targets:
            tree.links.new(node.outputs[out], target)
        tree.links.new(before.outputs[out], node.inputs[into])
    share = tree.nodes[edit.NODE + class_name].inputs["Share"].links[0].from_socket
    separate = tree.nodes.new("ShaderNodeSeparateColor")
    tree.links.new(tree.nodes[IMAGE].outputs["Color"], separate.inputs[0])
    is_it = tree.nodes.new("ShaderNodeMath")
    is_it.operation = "COMPARE"
    is_it.inputs[1].default_value, is_it.inputs[2].default_value = number / 255, 0.4 / 255
    tree.links.new(separate.outputs[0], is_it.inputs[0])
    tree.links.new(material.math_node(tree, "MULTIPLY", share, is_it.outputs[0]), node.inputs["Share"])
    return node


def _last_first(tree, class_name):
    mine = [node for node in tree.nodes if node.name.startswith(edit.NODE + class_name)]
    for node in mine:   # the last is the one that feeds none of the others
        if not any(link.to_node in mine for link in node.outputs["Base"].links):
            yield node
