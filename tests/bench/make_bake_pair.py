# A pair of meshes for the bake benchmark, run inside Blender:
#   blender -b --factory-startup --python-exit-code 1 --python tests/bench/make_bake_pair.py -- OUT [SCAN] [low]
# OUT/low.obj: SCAN (default: the example human) reduced to `low` triangles (default 31,250).
# OUT/high.obj: the same with each triangle cut in 16, rounded and displaced by 2 mm of noise: 500,000
# triangles. Both in centimetres, Y up, with the scan's UVs and diffuse picture.
import os
import shutil
import sys

import bpy
import numpy

numpy.bool = bool  # Debian's glTF importer is older than its numpy

arguments = sys.argv[sys.argv.index("--") + 1:]
out = arguments[0]
root = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
scan = arguments[1] if len(arguments) > 1 else os.path.join(root, "assets", "example_human", "example_human.glb")
wanted = int(arguments[2]) if len(arguments) > 2 else 31250


def load(path):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    if path.lower().endswith(".obj"):
        bpy.ops.wm.obj_import(filepath=path, global_scale=0.01)
    else:
        bpy.ops.import_scene.gltf(filepath=path)
    thing = next(o for o in bpy.context.scene.objects if o.type == "MESH")
    bpy.context.view_layer.objects.active = thing
    thing.select_set(True)
    bpy.ops.object.transform_apply(location=True, rotation=True, scale=True)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.remove_doubles(threshold=1e-6)
    bpy.ops.mesh.quads_convert_to_tris()
    bpy.ops.object.mode_set(mode="OBJECT")
    return thing


def copy_pictures():
    for image in bpy.data.images:
        if image.source != "FILE":
            continue
        target = os.path.join(out, os.path.basename(image.filepath) or image.name)
        if image.packed_file:
            with open(target, "wb") as file:
                file.write(image.packed_file.data)
        else:
            shutil.copy(bpy.path.abspath(image.filepath), target)


def apply(thing, kind, **settings):
    modifier = thing.modifiers.new(kind, kind)
    for name, value in settings.items():
        setattr(modifier, name, value)
    bpy.ops.object.modifier_apply(modifier=modifier.name)


def save(name):
    bpy.ops.wm.obj_export(filepath=os.path.join(out, name), export_selected_objects=True, global_scale=100,
                          export_triangulated_mesh=True, export_normals=False, path_mode="STRIP")
    print(name, len(bpy.context.object.data.polygons), "polygons")


os.makedirs(out, exist_ok=True)
thing = load(scan)
copy_pictures()
triangles = len(thing.data.polygons)
if triangles > wanted:
    apply(thing, "DECIMATE", ratio=wanted / triangles, use_collapse_triangulate=True)
save("low.obj")
# Each triangle becomes 3 quads, then 12: 24 triangles; a plain cut of every edge gives 4, then 16.
bpy.ops.object.mode_set(mode="EDIT")
bpy.ops.mesh.select_all(action="SELECT")
for _ in range(2):
    bpy.ops.mesh.subdivide(number_cuts=1, smoothness=0.5)
bpy.ops.object.mode_set(mode="OBJECT")
noise = bpy.data.textures.new("noise", "CLOUDS")
noise.noise_scale = 0.01
apply(thing, "DISPLACE", texture=noise, strength=0.004, mid_level=0.5, texture_coords="LOCAL")
save("high.obj")
