# SPDX-License-Identifier: GPL-3.0-or-later
"""A scan in the scene: an object whose mesh is in the scan's own unit and axes, so that a place on it is one of
strokes.xml. Y up becomes Blender's Z up by the object's rotation, its unit metres by its scale."""
import json
import math
import os
import zlib
from array import array

import bpy

from .. import compat
from . import vector
from .errors import InputError

SCAN, SHA256, UNIT, OPTIONS, STROKES, PRINT = ("hm_scan", "hm_scan_sha256", "hm_unit_cm", "hm_scan_options",
                                               "hm_strokes", "hm_mesh_print")
SAVED = "hm_strokes_saved"   # what the strokes.xml looked like that was written last
NUMBER, CLASS, CONFIDENCE = "hm_face", "hm_class", "hm_confidence"   # attributes of the mesh's faces


def is_scan(item):
    return item is not None and item.type == "MESH" and SCAN in item


def strokes_of(item):
    return json.loads(item[STROKES])


def set_strokes(item, strokes):
    item[STROKES] = json.dumps(strokes, separators=(",", ":"))


def build(scene, scan, name, path, unit_cm, options):
    """The object of a ScanMesh, linked and selected. options: {"unit", "up"} as the program was given them."""
    mesh = _mesh_of(scan, name)
    for material_name, picture, color in scan.materials:
        mesh.materials.append(_material(material_name, picture, color))
    item = bpy.data.objects.new(name, mesh)
    item.rotation_euler = (math.pi / 2, 0, 0)
    item.scale = [unit_cm / 100] * 3
    item[SCAN], item[SHA256], item[UNIT], item[OPTIONS] = path, scan.sha256, unit_cm, json.dumps(options)
    set_strokes(item, [])
    item[PRINT] = fingerprint(mesh)
    scene.collection.objects.link(item)
    return item


def _mesh_of(scan, name):
    faces, kept = scan.faces, scan.kept
    first, vertices, uvs = array("i"), array("i"), array("f")
    total = array("i")
    for f in kept:
        begin, end = faces.first_corner[f], faces.first_corner[f + 1]
        first.append(len(vertices))
        total.append(end - begin)
        vertices += faces.vertices[begin:end]
        uvs += faces.uvs[2 * begin:2 * end]
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(scan.positions) // 3)
    mesh.loops.add(len(vertices))
    mesh.polygons.add(len(kept))
    mesh.vertices.foreach_set("co", scan.positions)
    mesh.loops.foreach_set("vertex_index", vertices)
    mesh.polygons.foreach_set("loop_start", first)
    if not mesh.polygons.bl_rna or not bpy.types.MeshPolygon.bl_rna.properties["loop_total"].is_readonly:
        mesh.polygons.foreach_set("loop_total", total)
    mesh.polygons.foreach_set("material_index", array("i", [faces.materials[f] for f in kept]))
    mesh.polygons.foreach_set("use_smooth", [True] * len(kept))
    mesh.update(calc_edges=True)
    mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", uvs)
    mesh.attributes.new(NUMBER, "INT", "FACE").data.foreach_set("value", array("i", kept))
    for layer, value in ((CLASS, -1), (CONFIDENCE, 0)):
        mesh.attributes.new(layer, "INT", "FACE").data.foreach_set("value", array("i", [value]) * len(kept))
    return mesh


def _material(name, picture, color):
    material = bpy.data.materials.new(name or "scan")
    tree = compat.node_tree_of(material)
    material.diffuse_color = (*color, 1)
    shader = next(n for n in tree.nodes if n.type == "BSDF_PRINCIPLED")
    shader.inputs["Roughness"].default_value = 0.8
    shader.inputs["Base Color"].default_value = (*color, 1)
    if picture:
        image = bpy.data.images.load(picture, check_existing=True)
        if os.path.basename(picture).startswith("picture_"):
            image.pack()   # it was in the scan's file, and its own is a temporary one
        node = material.node_tree.nodes.new("ShaderNodeTexImage")
        node.image = image
        node.location = (-320, 300)
        material.node_tree.links.new(node.outputs["Color"], shader.inputs["Base Color"])
        material.node_tree.nodes.active = node   # what the viewport shows as the texture
    return material


def fingerprint(mesh):
    """Changes when a vertex moves or a face changes."""
    places, corners = array("f", bytes(12 * len(mesh.vertices))), array("i", bytes(4 * len(mesh.loops)))
    mesh.vertices.foreach_get("co", places)
    mesh.loops.foreach_get("vertex_index", corners)
    return "%08x%08x" % (zlib.crc32(places), zlib.crc32(corners, len(mesh.polygons)))


def expect_unchanged(item):
    """Raises InputError where the mesh is no longer the scan's: strokes on it would mean other faces."""
    if fingerprint(item.data) != item[PRINT]:
        raise InputError(item.name, "", "its mesh was changed after it was opened",
                         "undo the change, or open the scan again")


def face_numbers(mesh):
    """The scan's number of each of Blender's faces."""
    numbers = array("i", bytes(4 * len(mesh.polygons)))
    mesh.attributes[NUMBER].data.foreach_get("value", numbers)
    return numbers


def store(item, scan, classes, confidence):
    """Classes and confidence as attributes of the faces, for other tools of Blender."""
    for layer, values in ((CLASS, classes), (CONFIDENCE, confidence)):
        if len(scan.kept) == len(values):
            stored = array("i", list(values))   # of bytes it would take four for one
        else:
            stored = array("i", [values[f] for f in scan.kept])
        if layer not in item.data.attributes:   # removed by the user
            item.data.attributes.new(layer, "INT", "FACE")
        item.data.attributes[layer].data.foreach_set("value", stored)


def corner_brightness(item, scan):
    """How bright the picture is at each corner of the kept faces, from 0 to 1: overlays keep it, so that folds can be
    seen under the colours. Pictures are looked at in a small size."""
    seen = [_small_picture(material, *_SMALL) for material in item.data.materials]
    result = array("f")
    width, height = _SMALL
    for f in scan.kept:
        pixels = seen[scan.faces.materials[f]]
        for c in scan.faces.corners(f):
            if pixels is None:
                result.append(0.7)
                continue
            u, v = scan.faces.uvs[2 * c], scan.faces.uvs[2 * c + 1]
            result.append(pixels[int(v * height) % height * width + int(u * width) % width])
    return result


_SMALL = (512, 512)


def _small_picture(material, width, height):
    node = next((n for n in material.node_tree.nodes if n.type == "TEX_IMAGE" and n.image), None)
    if node is None or not node.image.has_data and not node.image.size[0]:
        return None
    small = node.image.copy()
    try:
        small.scale(width, height)
        pixels = array("f", bytes(4 * len(small.pixels)))
        small.pixels.foreach_get(pixels)
        channels = small.channels
    finally:
        bpy.data.images.remove(small)
    if vector.np:
        return array("f", vector.view(pixels, channels)[:, :3].mean(1).astype("f").tobytes())
    return array("f", [sum(pixels[k:k + 3]) / 3 for k in range(0, len(pixels), channels)])
