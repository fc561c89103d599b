"""Inside Blender: import scans and write what Blender shows of each.

blender -b --factory-startup -P blender_look.py -- out_folder scan.glb ...

<out_folder>/<stem>.txt: the vertices of the evaluated meshes in the file's axes (Y up), "x y z" a line.
<out_folder>/<stem>_colour.exr, _alpha.exr: base colour and opacity of the square [0,1] x [0,1], z = 0, seen
from +Z, 32 x 32 pixels, without light.
"""
import os
import sys

import bpy
import numpy

numpy.bool = bool  # Debian 12's numpy no longer has what Blender 3.4's glTF importer uses


def load(path):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    extension = path.rsplit(".", 1)[1].lower()
    if extension in ("glb", "gltf"):
        bpy.ops.import_scene.gltf(filepath=path)
    elif extension == "fbx":
        bpy.ops.import_scene.fbx(filepath=path)
    else:
        bpy.ops.wm.obj_import(filepath=path)


def write_vertices(path):
    graph = bpy.context.evaluated_depsgraph_get()
    with open(path, "w") as out:
        for thing in bpy.context.scene.objects:
            if thing.type != "MESH" or thing.hide_render or thing.name.startswith("Icosphere"):
                continue
            shown = thing.evaluated_get(graph)
            for vertex in shown.data.vertices:
                p = shown.matrix_world @ vertex.co
                out.write("%.9g %.9g %.9g\n" % (p.x, p.z, -p.y))


def show_socket(material, names):
    """Makes the material emit what goes into its shader's first socket of these names."""
    tree = material.node_tree
    shader = next((n for kind in ("BSDF_PRINCIPLED", "BSDF_DIFFUSE", "EMISSION") for n in tree.nodes
                   if n.type == kind and any(name in n.inputs for name in names)), None)
    emission = tree.nodes.new("ShaderNodeEmission")
    emission.inputs["Color"].default_value = (1, 1, 1, 1)
    socket = None if shader is None else next((shader.inputs[n] for n in names if n in shader.inputs), None)
    if socket is not None and socket.is_linked:
        tree.links.new(emission.inputs["Color"], socket.links[0].from_socket)
    elif socket is not None:
        value = socket.default_value
        emission.inputs["Color"].default_value = value if hasattr(value, "__len__") else (value,) * 3 + (1,)
    output = next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL")
    tree.links.new(output.inputs["Surface"], emission.outputs[0])


def render(path):
    scene = bpy.context.scene
    if scene.camera is None or scene.camera.name != "look":
        camera = bpy.data.objects.new("look", bpy.data.cameras.new("look"))
        camera.data.type = "ORTHO"
        camera.data.ortho_scale = 1
        camera.location = (0.5, -5, 0.5)
        camera.rotation_euler = (1.5707963267948966, 0, 0)
        scene.collection.objects.link(camera)
        scene.camera = camera
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 1
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.use_denoising = False
    scene.cycles.pixel_filter_type = "GAUSSIAN"
    scene.cycles.filter_width = 0.01
    scene.render.resolution_x = scene.render.resolution_y = 32
    scene.render.resolution_percentage = 100
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_mode = "RGB"
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = path
    bpy.ops.render.render(write_still=True)


folder, *scans = sys.argv[sys.argv.index("--") + 1:]
for scan in scans:
    stem = os.path.join(folder, os.path.splitext(os.path.basename(scan))[0])
    load(scan)
    write_vertices(stem + ".txt")
    for suffix, names in (("_alpha", ("Alpha",)), ("_colour", ("Base Color", "Color"))):
        load(scan)
        for material in bpy.data.materials:
            if material.use_nodes:
                show_socket(material, names)
        render(stem + suffix + ".exr")
