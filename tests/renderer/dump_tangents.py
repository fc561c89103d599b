# Run by tangent_frame_test.cpp inside Blender: for each folder given, reads positions.f32, triangles.u32 and
# corner_uvs.f32 and writes Blender's own vertex normals (normals.f32) and MikkTSpace tangents
# (tangents.f32: x, y, z, sign a corner), raw little-endian.
import array
import os
import sys

import bpy


def read(folder, name, kind):
    values = array.array(kind)
    with open(os.path.join(folder, name), "rb") as file:
        values.frombytes(file.read())
    return values


def write(folder, name, values):
    with open(os.path.join(folder, name), "wb") as file:
        file.write(values.tobytes())


def build(folder):
    positions = read(folder, "positions.f32", "f")
    triangles = read(folder, "triangles.u32", "I")
    uvs = read(folder, "corner_uvs.f32", "f")
    count = len(triangles) // 3
    mesh = bpy.data.meshes.new("mesh")
    mesh.vertices.add(len(positions) // 3)
    mesh.vertices.foreach_set("co", positions)
    mesh.loops.add(len(triangles))
    mesh.loops.foreach_set("vertex_index", triangles)
    mesh.polygons.add(count)
    mesh.polygons.foreach_set("loop_start", array.array("i", range(0, 3 * count, 3)))
    mesh.polygons.foreach_set("loop_total", array.array("i", [3]) * count)
    mesh.polygons.foreach_set("use_smooth", array.array("b", [1]) * count)
    mesh.uv_layers.new(name="uv").data.foreach_set("uv", uvs)
    mesh.update(calc_edges=True)
    return mesh


for folder in sys.argv[sys.argv.index("--") + 1:]:
    mesh = build(folder)
    normals = array.array("f", [0]) * (3 * len(mesh.vertices))
    mesh.vertex_normals.foreach_get("vector", normals)
    write(folder, "normals.f32", normals)
    mesh.calc_tangents(uvmap="uv")
    tangents = array.array("f", [0]) * (3 * len(mesh.loops))
    signs = array.array("f", [0]) * len(mesh.loops)
    mesh.loops.foreach_get("tangent", tangents)
    mesh.loops.foreach_get("bitangent_sign", signs)
    packed = array.array("f")
    for corner, sign in enumerate(signs):
        packed.extend(tangents[3 * corner:3 * corner + 3])
        packed.append(sign)
    write(folder, "tangents.f32", packed)
