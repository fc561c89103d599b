# SPDX-License-Identifier: Apache-2.0
"""Make the example human: a dressed person with known classes, from nothing but this script.

    blender -b --factory-startup --python-exit-code 1 --python assets/make_example_human.py -- OUT_DIR

Everything is procedural and has a fixed seed. About four minutes on two idle cores.
"""
import json
import os
import sys
import time

import bmesh
import bpy
import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
sys.dont_write_bytecode = True
from example_human_script import atlas, clothes, files, mesher, texture  # noqa: E402

NAME = "example_human"
TRIANGLES = 98000           # before the cut along class borders, which adds a few thousand
JPEG_QUALITY = 90
START = time.time()


def log(text):
    print("[%5.0f s] %s" % (time.time() - START, text), flush=True)


def make_grid():
    """Finer steps at the head and the hands."""
    xs = mesher.axis_samples([(-68, -44, 0.34), (-44, -10, 0.46), (-10, 10, 0.26), (10, 44, 0.46), (44, 68, 0.34)])
    ys = mesher.axis_samples([(-1.2, 80, 0.46), (80, 108, 0.36), (108, 148, 0.46), (148, 182, 0.26)])
    zs = mesher.axis_samples([(-18, -3, 0.40), (-3, 15, 0.29), (15, 23, 0.40)])
    grid, count = mesher.sample_field(clothes.distance, xs, ys, zs)
    log("distance field: %s grid, %d samples near the surface" % (grid.shape, count))
    return grid, xs, ys, zs


def detail_weight(p):
    """How much to spare a place from simplification: face most, then hands and edges."""
    face = np.exp(-(((p - (0, 161.5, 9)) / (6.5, 7.5, 6)) ** 2).sum(1))
    eyes = np.exp(-(((np.abs(p[:, :2]) - (3.1, 164)) / (2.2, 1.5)) ** 2).sum(1)) * (p[:, 2] > 6)
    hands = (np.abs(p[:, 0]) > 50) & (p[:, 1] < 103)
    head = p[:, 1] > 151
    ears = (np.abs(p[:, 0]) > 7.0) & (np.abs(p[:, 1] - 162.8) < 3.6) & (np.abs(p[:, 2] + 0.5) < 2.6)
    return np.clip(0.10 * head + 0.35 * ears + 0.45 * face + 0.45 * eyes + 0.25 * hands, 0, 1)


def simplify(vertices, faces, wanted):
    """Blender's edge-collapse decimation, guided by detail_weight."""
    mesh = bpy.data.meshes.new("dense")
    mesh.vertices.add(len(vertices))
    mesh.vertices.foreach_set("co", vertices.astype(np.float32).ravel())
    mesh.loops.add(faces.size)
    mesh.loops.foreach_set("vertex_index", faces.astype(np.int32).ravel())
    mesh.polygons.add(len(faces))
    mesh.polygons.foreach_set("loop_start", np.arange(0, faces.size, 3, dtype=np.int32))
    mesh.polygons.foreach_set("loop_total", np.full(len(faces), 3, np.int32))
    mesh.update(calc_edges=True)
    obj = bpy.data.objects.new("dense", mesh)
    bpy.context.scene.collection.objects.link(obj)
    group = obj.vertex_groups.new(name="spare")
    steps = np.round(detail_weight(vertices) * 20).astype(int)
    for step in range(1, 21):
        rows = np.flatnonzero(steps == step)
        if len(rows):
            group.add(rows.tolist(), step / 20, "REPLACE")
    modifier = obj.modifiers.new("simplify", "DECIMATE")
    modifier.ratio = wanted / len(faces)
    modifier.vertex_group, modifier.vertex_group_factor, modifier.invert_vertex_group = "spare", 3.0, True
    result = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
    out_v = np.zeros(len(result.vertices) * 3, np.float32)
    result.vertices.foreach_get("co", out_v)
    result.calc_loop_triangles()
    out_f = np.zeros(len(result.loop_triangles) * 3, np.int32)
    result.loop_triangles.foreach_get("vertices", out_f)
    bpy.data.objects.remove(obj)
    return mesher.compact(out_v.reshape(-1, 3), out_f.reshape(-1, 3).astype(np.int64))


def without_slivers(vertices, faces):
    """Collapse needle-like triangles; keep the mesh as it was if that would open it."""
    mesh = bpy.data.meshes.new("slivers")
    mesh.from_pydata(vertices.tolist(), [], faces.tolist())
    work = bmesh.new()
    work.from_mesh(mesh)
    bmesh.ops.dissolve_degenerate(work, dist=0.02, edges=work.edges)
    bmesh.ops.triangulate(work, faces=work.faces)
    work.verts.index_update()
    fresh_v = np.array([v.co[:] for v in work.verts])
    fresh_f = np.array([[v.index for v in f.verts] for f in work.faces])
    work.free()
    result = mesher.check(fresh_v, fresh_f)
    log("without slivers: %d triangles, closed %s, smallest %.2g cm2" % (
        len(fresh_f), result["closed"], result["smallest_face_cm2"]))
    good = result["closed"] and result["manifold_edges"] and result["components"] == 1
    better = result["smallest_face_cm2"] > mesher.check(vertices, faces)["smallest_face_cm2"]
    return (fresh_v, fresh_f) if good and better else (vertices, faces)


def class_distances(p):
    d = clothes.distances(p)
    return np.stack([d[clothes.CLASS_OF_PART == c].min(0) for c in range(len(clothes.CLASSES))])


def class_gap(p, a, b):
    d = class_distances(p)
    rows = np.arange(len(p))
    return d[a, rows] - d[b, rows]


def make_mesh():
    grid, xs, ys, zs = make_grid()
    vertices, faces = mesher.march(grid, xs, ys, zs)
    vertices, faces, count = mesher.largest_component(vertices, faces)
    log("surface: %d triangles; %d component(s), kept the largest" % (len(faces), count))
    vertices, faces = simplify(vertices, faces, TRIANGLES)
    log("simplified to %d triangles" % len(faces))
    vertices, faces = mesher.cut_along_classes(
        vertices, faces, lambda p: class_distances(p).argmin(0), class_gap)
    log("cut along the class borders: %d triangles" % len(faces))
    vertices, faces = without_slivers(vertices, faces)
    return vertices, faces, texture.Grid(grid, xs, ys, zs)


def classify(vertices, faces):
    """Class and part of each face, from the nearest part at its centre."""
    d = clothes.distances(vertices[faces].mean(1))
    part = d.argmin(0)
    return clothes.CLASS_OF_PART[part], part


def save(out_dir, vertices, faces, uv_px, face_class, picture, numbers):
    path = lambda ending: os.path.join(out_dir, NAME + ending)  # noqa: E731
    files.write_jpeg(path("_diffuse.jpg"), picture, JPEG_QUALITY)
    corner = np.concatenate([vertices[faces].reshape(-1, 3), uv_px.reshape(-1, 2) / atlas.ATLAS_PX], 1)
    corner = corner.astype(np.float32)
    unique, inverse = np.unique(corner, axis=0, return_inverse=True)
    uv = unique[:, 3:].copy()
    uv[:, 1] = 1 - uv[:, 1]                              # glTF counts v from the top
    files.write_glb(path(".glb"), unique[:, :3] / 100, uv, inverse.reshape(-1, 3), NAME + "_diffuse.jpg")
    files.write_text(path(".labels.txt"), "\n".join(map(str, face_class)) + "\n")
    files.write_text(path(".json"), json.dumps(numbers, indent=1) + "\n")
    for ending in (".glb", "_diffuse.jpg", ".labels.txt", ".json"):
        log("wrote %s%s (%d KiB)" % (NAME, ending, files.kib(path(ending))))


def describe(vertices, faces, face_class, result, overlap):
    p = vertices[faces].astype(np.float64)
    area = np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1) / 2
    size = vertices.max(0) - vertices.min(0)
    return {
        "name": NAME, "units": "m in the GLB (glTF); areas here in cm2", "up": "+Y", "facing": "+Z",
        "height_cm": round(float(size[1]), 2), "classes": clothes.CLASSES, "labels": NAME + ".labels.txt",
        "diffuse": NAME + "_diffuse.jpg", "atlas_px": atlas.ATLAS_PX,
        "triangles": len(faces), "vertices_welded": result["welded_vertices"],
        "closed": result["closed"], "manifold": result["manifold_edges"], "components": result["components"],
        "texels_covered_twice": overlap,
        "faces_of_class": {n: int((face_class == i).sum()) for i, n in enumerate(clothes.CLASSES)},
        "area_cm2_of_class": {n: round(float(area[face_class == i].sum()), 1) for i, n in enumerate(clothes.CLASSES)},
        "parts_of_class": {n: [part[0] for part in clothes.PARTS if part[1] == i] for i, n in enumerate(clothes.CLASSES)},
        "licence": "script Apache-2.0, asset CC0-1.0",
        "made_by": "assets/make_example_human.py: signed distance field, marching tetrahedra, procedural texture"}


def main():
    out_dir = sys.argv[sys.argv.index("--") + 1]
    os.makedirs(out_dir, exist_ok=True)
    vertices, faces, grid = make_mesh()
    low, high = vertices.min(0), vertices.max(0)
    shift = np.array([-(low[0] + high[0]) / 2, -low[1], -(low[2] + high[2]) / 2])
    face_class, part = classify(vertices, faces)
    weight = 1.0 + 0.75 * np.clip(1.4 * detail_weight(vertices[faces].mean(1)), 0, 1)
    for number in np.unique(part):                       # one scale per chart region
        weight[part == number] = weight[part == number].mean()
    weight[np.isin(part, (clothes.SKIN_HEAD, clothes.BEARD))] = 2.2
    uv_px, image, _, overlap = atlas.make_atlas(vertices, faces, part, weight, log)
    row, column, samples = texture.surface_samples(vertices, faces, uv_px, image, face_class, grid)
    log("sampled %d texels" % len(row))
    picture = texture.paint_atlas(atlas.ATLAS_PX, row, column, samples, log)
    placed = (vertices + shift).astype(np.float32)
    result = mesher.check(placed, faces)
    log(str(result))
    save(out_dir, placed, faces, uv_px, face_class, picture,
         describe(placed, faces, face_class, result, overlap))
    if os.environ.get("EXAMPLE_HUMAN_DEBUG"):
        np.savez(os.environ["EXAMPLE_HUMAN_DEBUG"], v=vertices, f=faces, uv=uv_px / atlas.ATLAS_PX, part=part)


main()
