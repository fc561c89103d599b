# SPDX-License-Identifier: GPL-3.0-or-later
"""A model that `openhumanbrdf bake` wrote, in the scene: its mesh with its maps (docs/conventions.md)."""
import math
import os
import xml.etree.ElementTree

import bpy

from .. import compat
from . import material
from .errors import InputError

MODEL = "hm_model"   # the object's property: the folder
NOT_SHOWN = ("displacement",)   # the mesh has its shape already


def sets_of(folder):
    """name of a texture set -> {map: file}, as model.xml lists them. Raises InputError."""
    path = os.path.join(folder, "model.xml")
    try:
        root = xml.etree.ElementTree.parse(path).getroot()
        found = {entry.attrib["name"]: {m.attrib["name"]: os.path.join(folder, "maps", entry.attrib["folder"],
                                                                       m.attrib["name"] + ".exr")
                                        for m in entry.iter("map")} for entry in root.iter("texture_set")}
    except (OSError, xml.etree.ElementTree.ParseError, KeyError):
        raise InputError(path, "", "is no model of `openhumanbrdf bake`", "choose the folder that Bake wrote") from None
    for maps in found.values():
        for file in maps.values():
            if not os.path.isfile(file):
                raise InputError(file, "", "the map is not there", "bake again")
    if not found:
        raise InputError(path, "", "has no texture set", "bake again")
    return found


def show(scene, folder):
    """The model's object, to the right of what is there. Raises InputError; then the scene is as it was."""
    sets = sets_of(folder)
    mesh = _read_mesh(os.path.join(folder, "mesh.obj"), list(sets))
    item = bpy.data.objects.new(os.path.basename(os.path.normpath(folder)), mesh)
    for name, maps in sets.items():
        mesh.materials.append(_material(name, maps))
    item.rotation_euler, item.scale = (math.pi / 2, 0, 0), [0.01] * 3
    item[MODEL] = folder
    others = [o for o in scene.objects if o.type == "MESH"]
    scene.collection.objects.link(item)
    if others:
        right = max((o.matrix_world @ o.data.vertices[0].co).x if o.data.vertices else 0 for o in others)
        item.location.x = right + 1.0
    return item


def _read_mesh(path, sets):
    """bake's own OBJ: triangles, `f v/t`; faces of a set follow its usemtl."""
    positions, uvs, vertices, corners, indices, current = [], [], [], [], [], 0
    try:
        with open(path, encoding="utf-8") as file:
            for line in file:
                kind, _, rest = line.partition(" ")
                if kind == "v":
                    positions += map(float, rest.split()[:3])
                elif kind == "vt":
                    uvs += map(float, rest.split()[:2])
                elif kind == "usemtl":
                    current = sets.index(rest.strip())
                elif kind == "f":
                    parts = [corner.split("/") for corner in rest.split()]
                    vertices += [int(part[0]) - 1 for part in parts]
                    corners += [int(part[1]) - 1 for part in parts]
                    indices.append(current)
        if len(vertices) != 3 * len(indices) or max(vertices) >= len(positions) // 3:
            raise ValueError
        mesh = bpy.data.meshes.new("model")
        mesh.vertices.add(len(positions) // 3)
        mesh.loops.add(len(vertices))
        mesh.polygons.add(len(indices))
        mesh.vertices.foreach_set("co", positions)
        mesh.loops.foreach_set("vertex_index", vertices)
        mesh.polygons.foreach_set("loop_start", range(0, len(vertices), 3))
        if not bpy.types.MeshPolygon.bl_rna.properties["loop_total"].is_readonly:
            mesh.polygons.foreach_set("loop_total", [3] * len(indices))
        mesh.polygons.foreach_set("material_index", indices)
        mesh.polygons.foreach_set("use_smooth", [True] * len(indices))
        mesh.update(calc_edges=True)
        mesh.uv_layers.new(name="uv").data.foreach_set("uv", [u for c in corners for u in uvs[2 * c:2 * c + 2]])
        return mesh
    except (OSError, ValueError, IndexError):
        raise InputError(path, "", "is no mesh of `openhumanbrdf bake`", "bake again") from None


def _texture(tree, file, y, is_color=False):
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = bpy.data.images.load(file, check_existing=True)
    if not is_color:   # an EXR's colours are linear by default
        node.image.colorspace_settings.name = "Non-Color"
    node.location = (-900, y)
    return node.outputs["Color"]


def _material(name, maps):
    made = bpy.data.materials.new(name)
    tree = compat.node_tree_of(made)
    shader = next(n for n in tree.nodes if n.type == "BSDF_PRINCIPLED")
    compat.prepare_principled(shader)
    compat.set_subsurface_method(shader, "random_walk_skin")
    for row, key in enumerate(k for k in maps if k not in NOT_SHOWN):
        _link(tree, shader, key, _texture(tree, maps[key], 500 - 300 * row, key == "albedo"))
    if "alpha" in maps:
        compat.set_cut_out(made)
    return made


def _link(tree, shader, key, output):
    def to(meaning, value):
        socket = compat.principled_socket(shader, meaning)
        if socket is not None:
            tree.links.new(value, socket)
    if key == "albedo":
        to("base", output)
        to("subsurface_color", output)
        tree.nodes.active = output.node   # what the viewport shows as the texture
    elif key == "specular":   # an sRGB code of F0
        to("specular", material.math_node(tree, "DIVIDE", _srgb_to_linear(tree, output), material.F0_PER_SPECULAR))
    elif key == "sss":
        to("subsurface_scale", output)
        compat.principled_socket(shader, "subsurface_radius").default_value = material.RADIUS_M
    elif key == "alpha":
        tree.links.new(output, shader.inputs["Alpha"])
    elif key == "normal":
        to("normal", _normal(tree, output))
    elif key == "roughness":
        to("roughness", output)


def _srgb_to_linear(tree, code):
    """The piecewise curve of IEC 61966-2-1."""
    math_node = material.math_node
    low = math_node(tree, "DIVIDE", code, 12.92)
    high = math_node(tree, "POWER", math_node(tree, "DIVIDE", math_node(tree, "ADD", code, 0.055), 1.055), 2.4)
    above = math_node(tree, "GREATER_THAN", code, 0.04045)
    return math_node(tree, "ADD", low, math_node(tree, "MULTIPLY", above, math_node(tree, "SUBTRACT", high, low)))


def _normal(tree, output):
    """Signed values, where the Normal Map node wants (n + 1) / 2."""
    half = tree.nodes.new("ShaderNodeVectorMath")
    half.operation = "MULTIPLY_ADD"
    half.inputs[1].default_value = half.inputs[2].default_value = (0.5, 0.5, 0.5)
    tree.links.new(output, half.inputs[0])
    node = tree.nodes.new("ShaderNodeNormalMap")
    node.uv_map = "uv"
    tree.links.new(half.outputs["Vector"], node.inputs["Color"])
    return node.outputs["Normal"]
