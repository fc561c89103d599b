"""Runs in Blender in place of validation_scene.py: the same camera, light and settings, but the scan as Blender's own
importer reads it, with its own pictures and the values of the classes face by face.

Environment: OHB_SCAN (.glb or .obj, one mesh), OHB_LABELS (a class a line in the order of its faces), OHB_MODEL (the
folder that bake wrote: unit and shift), OHB_ROOT (the repository); OHB_ENCODED=1 leaves the pictures in 8 bits, which
Cycles filters before it decodes them.
"""
import json
import os
import sys
import xml.etree.ElementTree as xml

import bmesh
import bpy
import numpy

for old in ("bool", "int", "float", "object"):   # names that Debian's numpy 1.24 no longer has and its importer uses
    if old not in numpy.__dict__:
        setattr(numpy, old, {"bool": bool, "int": int, "float": float, "object": object}[old])

ROOT = os.environ["OHB_ROOT"]
sys.path.insert(0, os.path.join(ROOT, "blender_addon"))
import validation_objects  # noqa: E402
import validation_scene  # noqa: E402
import validation_settings  # noqa: E402

CLASSES = ("skin", "hair", "fabric", "leather")


def srgb_to_linear(value):
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4


def import_scan(path):
    """The scan's one mesh; Blender's axes, its own unit."""
    if path.lower().endswith(".obj"):
        bpy.ops.wm.obj_import(filepath=path, forward_axis="NEGATIVE_Z", up_axis="Y")
    else:
        bpy.ops.import_scene.gltf(filepath=path)
    objects = [thing for thing in bpy.data.objects if thing.type == "MESH"]
    if len(objects) != 1:
        raise ValueError("%s: %d meshes; this needs one" % (path, len(objects)))
    mesh = objects[0].data
    mesh.transform(objects[0].matrix_world)
    for thing in list(bpy.data.objects):
        bpy.data.objects.remove(thing)
    return mesh


def place(mesh, model):
    """As bake placed it: position in cm = source x unit + shift; here metres and Blender's axes."""
    source = xml.parse(os.path.join(model, "model.xml")).getroot().find("source")
    unit = float(source.get("unit_cm")) * 0.01
    x, y, z = (float(source.get("shift_%s_cm" % axis)) * 0.01 for axis in "xyz")
    for vertex in mesh.vertices:
        p = vertex.co
        vertex.co = (p.x * unit + x, p.y * unit - z, p.z * unit + y)


def weld(mesh):
    """glTF splits vertices at UV seams: smooth normals would crack there."""
    faces = len(mesh.polygons)
    work = bmesh.new()
    work.from_mesh(mesh)
    bmesh.ops.remove_doubles(work, verts=work.verts, dist=1e-7)
    work.to_mesh(mesh)
    work.free()
    if len(mesh.polygons) != faces:
        raise ValueError("welding lost %d faces" % (faces - len(mesh.polygons)))


def picture_of(material):
    """The image that the importer linked to Base Color."""
    socket = material.node_tree.nodes["Principled BSDF"].inputs["Base Color"]
    return socket.links[0].from_node.image


def decoded_first(image):
    """The picture in linear light. Cycles filters 8-bit colours before it decodes them, which darkens them."""
    width, height = image.size
    pixels = numpy.empty(4 * width * height, dtype=numpy.float32)
    image.pixels.foreach_get(pixels)   # of 8-bit pictures: encoded
    colour = pixels.reshape(-1, 4)[:, :3]
    colour[:] = numpy.where(colour <= 0.04045, colour / 12.92, ((colour + 0.055) / 1.055) ** 2.4)
    linear = bpy.data.images.new("linear", width, height, alpha=True, float_buffer=True, is_data=False)
    linear.colorspace_settings.name = "Linear"
    linear.pixels.foreach_set(pixels)
    linear.update()
    return linear


def build_material(mesh, image, name, values):
    specular, roughness, sss = values
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    material.cycles.displacement_method = "BUMP"
    tree = material.node_tree
    settings = validation_settings.Settings()
    node = validation_objects.principled_node(settings, tree)
    uv = tree.nodes.new("ShaderNodeUVMap")
    uv.uv_map = mesh.uv_layers[0].name
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = image
    tree.links.new(uv.outputs["UV"], texture.inputs["Vector"])
    tree.links.new(texture.outputs["Color"], node.inputs["Base Color"])
    node.inputs["Roughness"].default_value = roughness
    node.inputs["Specular"].default_value = srgb_to_linear(specular) / 0.08
    node.inputs["Subsurface"].default_value = sss
    node.inputs["Subsurface Radius"].default_value = (0.01, 0.002, 0.001)
    node.inputs["Subsurface IOR"].default_value = 1.4
    node.inputs["Subsurface Anisotropy"].default_value = 0.0
    tree.links.new(texture.outputs["Color"], node.inputs["Subsurface Color"])
    return material


def class_values():
    table = {}
    for entry in xml.parse(os.path.join(ROOT, "assets/materials.xml")).getroot().iter("material"):
        table[entry.get("class")] = tuple(float(entry.get(key)) for key in ("specular", "roughness", "sss"))
    return [table[name] for name in CLASSES]


def build_mesh(folder, _description):
    with open(os.path.join(folder, "scene.json"), encoding="utf-8") as file:
        sss_scale = json.load(file)["sss_scale"]
    mesh = import_scan(os.environ["OHB_SCAN"])
    place(mesh, os.environ["OHB_MODEL"])
    weld(mesh)
    labels = [int(line) for line in open(os.environ["OHB_LABELS"], encoding="utf-8").read().split()]
    if len(labels) != len(mesh.polygons):
        raise ValueError("%d labels for %d faces" % (len(labels), len(mesh.polygons)))
    images = [picture_of(material) for material in mesh.materials]
    numbers = [4 * polygon.material_index + label for polygon, label in zip(mesh.polygons, labels)]
    values = [(specular, roughness, sss * sss_scale) for specular, roughness, sss in class_values()]
    mesh.materials.clear()
    for i, image in enumerate(images):
        if image.colorspace_settings.name != "sRGB":
            raise ValueError("%s is not read as sRGB" % image.name)
        if not os.environ.get("OHB_ENCODED"):
            image = decoded_first(image)
        for name, value in zip(CLASSES, values):
            mesh.materials.append(build_material(mesh, image, "%d.%s" % (i, name), value))
    mesh.polygons.foreach_set("material_index", numbers)
    mesh.polygons.foreach_set("use_smooth", [True] * len(numbers))
    mesh.update()
    return mesh


validation_objects.build_mesh = build_mesh
arguments = sys.argv[sys.argv.index("--") + 1:]
validation_scene.run(arguments[0], int(arguments[1]))
