# SPDX-License-Identifier: GPL-3.0-or-later
"""What stands in the scene of `openhumanbrdf validate`: mesh, materials, world, lights, camera.

The names of sockets are those of Blender 3.4 (Principled v1), or of 4.5 (v2) where IS_V2 is true.
"""
import array
import os
import sys

import bpy
from mathutils import Matrix

from validation_settings import IS_V2

LINEAR = "Linear Rec.709" if IS_V2 else "Linear"
LEAST_SUBSURFACE = 1e-5


# Mesh ---------------------------------------------------------------------------------------------------

def read_array(folder, name, kind):
    values = array.array(kind)
    with open(os.path.join(folder, name), "rb") as file:
        values.frombytes(file.read())
    if sys.byteorder == "big":
        values.byteswap()
    return values


def build_mesh(folder, description):
    """Triangles with smooth shading on shared vertices: the normals are Blender's own."""
    positions = read_array(folder, description["positions"], "f")
    triangles = read_array(folder, description["triangles"], "i")
    count = len(triangles) // 3
    mesh = bpy.data.meshes.new("model")
    mesh.vertices.add(len(positions) // 3)
    mesh.vertices.foreach_set("co", positions)
    mesh.loops.add(len(triangles))
    mesh.loops.foreach_set("vertex_index", triangles)
    mesh.polygons.add(count)
    mesh.polygons.foreach_set("loop_start", array.array("i", range(0, 3 * count, 3)))
    mesh.polygons.foreach_set("loop_total", array.array("i", [3]) * count)
    mesh.polygons.foreach_set("use_smooth", array.array("b", [1]) * count)
    mesh.polygons.foreach_set("material_index", read_array(folder, description["sets"], "i"))
    mesh.uv_layers.new(name="uv").data.foreach_set("uv", read_array(folder, description["corner_uvs"], "f"))
    mesh.update(calc_edges=True)
    return mesh


def add_object(settings, mesh, turn):
    thing = bpy.data.objects.new("model", mesh)
    bpy.context.scene.collection.objects.link(thing)
    settings.set("object", thing, "rotation_euler", (0.0, 0.0, turn))
    if IS_V2:   # those of object.cycles are still there and do nothing
        settings.set_all("object", thing, {
            "shadow_terminator_shading_offset": 0.0, "shadow_terminator_geometry_offset": 0.0})
    else:
        settings.set("mesh", mesh, "use_auto_smooth", False)
        settings.set_all("object.cycles", thing.cycles, {
            "shadow_terminator_offset": 0.0, "shadow_terminator_geometry_offset": 0.0})
    return thing


# Material -----------------------------------------------------------------------------------------------

def load_image(settings, path, colorspace):
    image = bpy.data.images.load(path)
    name = "image " + os.path.basename(path)
    settings.set(name, image.colorspace_settings, "name", colorspace)
    settings.set(name, image, "alpha_mode", "NONE")
    return image


def image_node(settings, tree, path, colorspace):
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = load_image(settings, path, colorspace)
    settings.set_all("texture " + os.path.basename(path), node, {
        "interpolation": "Linear", "extension": "REPEAT", "projection": "FLAT"})
    uv = tree.nodes.get("uv")
    tree.links.new(uv.outputs["UV"], node.inputs["Vector"])
    return node.outputs["Color"]


def math_node(tree, operation, a, b):
    """A Math node of two inputs, each a socket or a number; its output socket."""
    node = tree.nodes.new("ShaderNodeMath")
    node.operation = operation
    for socket, value in zip(node.inputs, (a, b)):
        if isinstance(value, (int, float)):
            socket.default_value = value
        else:
            tree.links.new(value, socket)
    return node.outputs["Value"]


def srgb_to_linear(tree, encoded):
    """The piecewise sRGB curve (IEC 61966-2-1) as Math nodes."""
    low = math_node(tree, "DIVIDE", encoded, 12.92)
    base = math_node(tree, "DIVIDE", math_node(tree, "ADD", encoded, 0.055), 1.055)
    high = math_node(tree, "POWER", base, 2.4)
    above = math_node(tree, "GREATER_THAN", encoded, 0.04045)
    step = math_node(tree, "MULTIPLY", above, math_node(tree, "SUBTRACT", high, low))
    return math_node(tree, "ADD", low, step)


def normal_socket(settings, tree, path):
    """A signed tangent-space normal map: n / 2 + 1 / 2 is what the Normal Map node expects."""
    encode = tree.nodes.new("ShaderNodeVectorMath")
    encode.operation = "MULTIPLY_ADD"
    encode.inputs[1].default_value = encode.inputs[2].default_value = (0.5, 0.5, 0.5)
    tree.links.new(image_node(settings, tree, path, "Non-Color"), encode.inputs[0])
    node = tree.nodes.new("ShaderNodeNormalMap")
    settings.set_all("normal map", node, {"space": "TANGENT", "uv_map": "uv"})
    node.inputs["Strength"].default_value = 1.0
    tree.links.new(encode.outputs["Vector"], node.inputs["Color"])
    return node.outputs["Normal"]


def link_subsurface(settings, tree, principled, path, scale, albedo):
    """The map scales the radius (1, .2, .1) cm. v1: Subsurface does, which is no blend weight there. v2: Scale does,
    and the weight is 1 where there is any."""
    weight = math_node(tree, "MULTIPLY", image_node(settings, tree, path, "Non-Color"), scale)
    if IS_V2:
        tree.links.new(weight, principled.inputs["Subsurface Scale"])
        is_some = math_node(tree, "GREATER_THAN", weight, LEAST_SUBSURFACE)
        tree.links.new(is_some, principled.inputs["Subsurface Weight"])
    else:
        tree.links.new(weight, principled.inputs["Subsurface"])
        tree.links.new(albedo, principled.inputs["Subsurface Color"])
    settings.set("Subsurface Radius", principled.inputs["Subsurface Radius"], "default_value",
                 (0.01, 0.002, 0.001))
    settings.set("Subsurface IOR", principled.inputs["Subsurface IOR"], "default_value", 1.4)
    settings.set("Subsurface Anisotropy", principled.inputs["Subsurface Anisotropy"], "default_value", 0.0)


def principled_node(settings, tree):
    node = tree.nodes.get("Principled BSDF")
    if IS_V2:
        choices = {"distribution": "MULTI_GGX", "subsurface_method": "RANDOM_WALK_SKIN"}
        zeros = ("Subsurface Weight", "Metallic", "Diffuse Roughness", "Anisotropic", "Sheen Weight", "Coat Weight",
                 "Transmission Weight", "Emission Strength", "Thin Film Thickness")
        settings.set("Principled BSDF IOR", node.inputs["IOR"], "default_value", 1.5)
        settings.set("Principled BSDF Specular Tint", node.inputs["Specular Tint"], "default_value",
                     (1.0, 1.0, 1.0, 1.0))
    else:
        choices = {"distribution": "GGX", "subsurface_method": "RANDOM_WALK"}
        zeros = ("Subsurface", "Metallic", "Specular Tint", "Anisotropic", "Sheen", "Clearcoat", "Transmission",
                 "Emission Strength")
    settings.set_all("Principled BSDF", node, choices)
    for name in zeros:
        settings.set("Principled BSDF " + name, node.inputs[name], "default_value", 0.0)
    settings.set("Principled BSDF Alpha", node.inputs["Alpha"], "default_value", 1.0)
    return node


def build_material(settings, folder, texture_set, sss_scale):
    """Principled v1 of one texture set. Maps that are null are left out (opaque, flat, no subsurface)."""
    material = bpy.data.materials.new(texture_set["name"])
    material.use_nodes = True
    if IS_V2:
        settings.set("material", material, "displacement_method", "BUMP")
        settings.set("material.cycles", material.cycles, "use_bump_map_correction", True)
    else:
        settings.set("material.cycles", material.cycles, "displacement_method", "BUMP")
    tree = material.node_tree
    principled = principled_node(settings, tree)
    uv = tree.nodes.new("ShaderNodeUVMap")
    uv.name = uv.uv_map = "uv"

    def linked(name, socket, colorspace="Non-Color", convert=lambda value: value):
        if texture_set[name]:
            path = os.path.join(folder, texture_set[name])
            output = convert(image_node(settings, tree, path, colorspace))
            tree.links.new(output, principled.inputs[socket])
            return output
        return None

    albedo = linked("albedo", "Base Color", LINEAR)
    linked("roughness", "Roughness")
    linked("specular", "Specular IOR Level" if IS_V2 else "Specular",
           convert=lambda value: math_node(tree, "DIVIDE", srgb_to_linear(tree, value), 0.08))
    linked("alpha", "Alpha")
    if texture_set["normal"]:
        path = os.path.join(folder, texture_set["normal"])
        tree.links.new(normal_socket(settings, tree, path), principled.inputs["Normal"])
    if texture_set["sss"] and sss_scale > 0:
        path = os.path.join(folder, texture_set["sss"])
        link_subsurface(settings, tree, principled, path, sss_scale, albedo)
    return material


# World, lights, camera ----------------------------------------------------------------------------------

def build_world(settings, folder, environment):
    """The environment as it is; black if there is none."""
    world = bpy.data.worlds.new("world")
    bpy.context.scene.world = world
    world.use_nodes = True
    background = world.node_tree.nodes["Background"]
    settings.set("Background", background.inputs["Strength"], "default_value", 1.0)
    if environment is None:
        settings.set("Background", background.inputs["Color"], "default_value", (0.0, 0.0, 0.0, 1.0))
        return
    node = world.node_tree.nodes.new("ShaderNodeTexEnvironment")
    node.image = load_image(settings, os.path.join(folder, environment["file"]), LINEAR)
    settings.set_all("environment", node, {"interpolation": "Linear", "projection": "EQUIRECTANGULAR"})
    world.node_tree.links.new(node.outputs["Color"], background.inputs["Color"])
    settings.set_all("world.cycles", world.cycles, {
        "sampling_method": "MANUAL", "sample_map_resolution": max(4, min(8192, 4 * environment["width_px"]))})


def add_point_light(settings, number, point):
    """Radiant intensity in W/sr by channel; Cycles wants the power of an isotropic light, 4 pi times that."""
    light = bpy.data.lights.new("point%d" % number, "POINT")
    strength = max(point["intensity"]) or 1.0
    settings.set_all(light.name, light, {
        "energy": 4.0 * 3.14159265358979 * strength, "shadow_soft_size": 0.0, "use_nodes": False,
        "color": tuple(value / strength for value in point["intensity"])})
    if IS_V2:
        settings.set_all(light.name, light, {"use_soft_falloff": False, "normalize": True, "exposure": 0.0,
                                             "use_temperature": False})
    thing = bpy.data.objects.new(light.name, light)
    thing.location = point["position"]
    bpy.context.scene.collection.objects.link(thing)


def add_camera(settings, camera):
    """Looks along +Y with Z up."""
    data = bpy.data.cameras.new("camera")
    settings.set_all("camera", data, {
        "type": "PERSP", "sensor_fit": "AUTO", "sensor_width": camera["sensor_mm"], "lens": camera["lens_mm"],
        "shift_x": 0.0, "shift_y": 0.0, "clip_start": camera["clip_start"], "clip_end": camera["clip_end"]})
    settings.set("camera.dof", data.dof, "use_dof", False)
    thing = bpy.data.objects.new("camera", data)
    x, y, z = camera["location"]
    thing.matrix_world = Matrix(((1, 0, 0, x), (0, 0, -1, y), (0, 1, 0, z), (0, 0, 0, 1)))
    bpy.context.scene.collection.objects.link(thing)
    bpy.context.scene.camera = thing
