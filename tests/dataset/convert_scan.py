"""Inside Blender: import an OBJ (numbers as they are) and export it as GLB and FBX.

blender -b --factory-startup -P convert_scan.py -- scan.obj scan.glb scan.fbx
"""
import sys

import bpy

source, glb, fbx = sys.argv[sys.argv.index("--") + 1:]
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.obj_import(filepath=source)
bpy.ops.export_scene.gltf(filepath=glb, export_format="GLB")
bpy.ops.export_scene.fbx(filepath=fbx, path_mode="COPY", embed_textures=True)
