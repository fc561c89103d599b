# The six bakes of a pair in Blender, as an artist would set them up, run by bake_bench.py inside Blender:
#   blender -b --factory-startup --python tests/bench/blender_bakes.py -- LOW HIGH SIZE EXTRUSION_CM OUT [MAPS]
# Selected to active, one sample, no margin beyond Blender's default 16 px, float images saved as EXR.
# MAPS: of normal,albedo,roughness,specular,sss,displacement (default: all). Prints the seconds of each bake.
import os
import sys
import time

import bpy

low_file, high_file, size, extrusion_cm, out = sys.argv[sys.argv.index("--") + 1:][:5]
maps = sys.argv[sys.argv.index("--") + 1:][5:]
maps = maps[0].split(",") if maps else ["normal", "albedo", "roughness", "specular", "sss", "displacement"]
CLASS = {"roughness": 0.85, "specular": 0.263, "sss": 0.0}


def load(path):
    before = set(bpy.data.objects)
    bpy.ops.wm.obj_import(filepath=path, forward_axis="NEGATIVE_Z", up_axis="Y", global_scale=0.01)
    thing = (set(bpy.data.objects) - before).pop()
    for polygon in thing.data.polygons:
        polygon.use_smooth = True
    return thing


bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.render.engine = "CYCLES"
scene.cycles.samples = 1
scene.cycles.use_denoising = False
scene.cycles.use_adaptive_sampling = False
high, low = load(high_file), load(low_file)

# The source emits what is to be baked; the low mesh's material only holds the image.
source = high.data.materials[0]
nodes, links = source.node_tree.nodes, source.node_tree.links
picture = next(node for node in nodes if node.type == "TEX_IMAGE")
output = next(node for node in nodes if node.type == "OUTPUT_MATERIAL")
emission = nodes.new("ShaderNodeEmission")
links.new(emission.outputs[0], output.inputs["Surface"])
position = nodes.new("ShaderNodeNewGeometry")
split = nodes.new("ShaderNodeSeparateXYZ")
links.new(position.outputs["Position"], split.inputs[0])

target_material = bpy.data.materials.new("target")
target_material.use_nodes = True
target = target_material.node_tree.nodes.new("ShaderNodeTexImage")
target_material.node_tree.nodes.active = target
low.data.materials.clear()
low.data.materials.append(target_material)
high.select_set(True)
low.select_set(True)
bpy.context.view_layer.objects.active = low

for name in maps:
    image = bpy.data.images.new(name, int(size), int(size), float_buffer=True, alpha=False)
    image.colorspace_settings.name = "Non-Color"
    target.image = image
    for link in list(emission.inputs["Color"].links):
        links.remove(link)
    if name == "albedo":
        links.new(picture.outputs["Color"], emission.inputs["Color"])
    elif name == "displacement":
        links.new(split.outputs["Y"], emission.inputs["Color"])
    elif name != "normal":
        emission.inputs["Color"].default_value = (CLASS[name], CLASS[name], CLASS[name], 1)
    start = time.time()
    bpy.ops.object.bake(type="NORMAL" if name == "normal" else "EMIT", use_selected_to_active=True,
                        cage_extrusion=float(extrusion_cm) / 100, max_ray_distance=2 * float(extrusion_cm) / 100,
                        normal_space="TANGENT")
    print(f"baked {name} in {time.time() - start:.1f} s", flush=True)
    image.filepath_raw = os.path.join(out, name + ".exr")
    image.file_format = "OPEN_EXR"
    image.save()
    bpy.data.images.remove(image)
