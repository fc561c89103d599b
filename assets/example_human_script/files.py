# SPDX-License-Identifier: Apache-2.0
"""Writers: GLB with exact face order, JPEG through Blender, labels and description."""
import json
import os
import struct

import bpy
import numpy as np


def write_glb(path, vertices_m, uv, triangles, texture_name):
    """One primitive; triangles keep their order. `uv` has its origin at the top left."""
    blobs = [vertices_m.astype("<f4").tobytes(), uv.astype("<f4").tobytes(), triangles.astype("<u4").tobytes()]
    views, offset = [], 0
    for blob, target in zip(blobs, (34962, 34962, 34963)):
        views.append({"buffer": 0, "byteOffset": offset, "byteLength": len(blob), "target": target})
        offset += len(blob)
    v32 = vertices_m.astype("<f4")
    document = {
        "asset": {"version": "2.0", "generator": "make_example_human.py", "copyright": "CC0-1.0"},
        "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0, "name": "example_human"}],
        "meshes": [{"name": "example_human", "primitives": [
            {"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0, "mode": 4}]}],
        "materials": [{"name": "scan", "pbrMetallicRoughness": {
            "baseColorTexture": {"index": 0}, "metallicFactor": 0.0, "roughnessFactor": 0.7}}],
        "textures": [{"source": 0, "sampler": 0}],
        "samplers": [{"magFilter": 9729, "minFilter": 9987, "wrapS": 33071, "wrapT": 33071}],
        "images": [{"uri": texture_name}], "buffers": [{"byteLength": offset}], "bufferViews": views,
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(v32), "type": "VEC3",
             "min": v32.min(0).tolist(), "max": v32.max(0).tolist()},
            {"bufferView": 1, "componentType": 5126, "count": len(uv), "type": "VEC2"},
            {"bufferView": 2, "componentType": 5125, "count": int(triangles.size), "type": "SCALAR"}]}
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    binary = b"".join(blobs)
    with open(path, "wb") as f:
        f.write(struct.pack("<4sII", b"glTF", 2, 12 + 8 + len(text) + 8 + len(binary)))
        f.write(struct.pack("<I4s", len(text), b"JSON") + text)
        f.write(struct.pack("<I4s", len(binary), b"BIN\0") + binary)


def write_jpeg(path, rgb, quality):
    """`rgb`: display values 0..1, first row at the bottom."""
    height, width = rgb.shape[:2]
    image = bpy.data.images.new("diffuse", width, height)
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., :3] = rgb
    image.pixels.foreach_set(rgba.ravel())
    scene = bpy.context.scene
    scene.view_settings.view_transform = "Standard"
    scene.render.image_settings.file_format = "JPEG"
    scene.render.image_settings.color_mode = "RGB"
    scene.render.image_settings.quality = quality
    image.save_render(path, scene=scene)
    bpy.data.images.remove(image)


def write_text(path, text):
    with open(path, "w", encoding="utf-8", newline="\n") as f:
        f.write(text)


def kib(path):
    return os.path.getsize(path) // 1024
