# How far baked normal maps are from the high mesh, measured inside Blender with its own tangents and its own
# ray casts: nothing of the baker under test takes part.
#   blender -b --factory-startup --python tests/bench/normal_error.py -- LOW HIGH MAP:signed|encoded...
# At random points of the low surface (not texel centres) the map is read bilinearly, decoded with calc_tangents
# and compared with the smooth normal of the first surface of the high mesh from 2 cm outside. Prints degrees.
import random
import sys

import bpy
import numpy
from mathutils import Vector
from mathutils.bvhtree import BVHTree

low_file, high_file, *maps = sys.argv[sys.argv.index("--") + 1:]
POINTS, REACH = 20000, 0.02


def load(path):
    before = set(bpy.data.objects)
    bpy.ops.wm.obj_import(filepath=path, forward_axis="NEGATIVE_Z", up_axis="Y", global_scale=0.01)
    thing = (set(bpy.data.objects) - before).pop()
    bpy.context.view_layer.objects.active = thing
    bpy.ops.object.select_all(action="DESELECT")
    thing.select_set(True)
    bpy.ops.object.transform_apply(location=True, rotation=True, scale=True)
    for polygon in thing.data.polygons:
        polygon.use_smooth = True
    return thing.data


def pixels(path):
    image = bpy.data.images.load(path)
    image.colorspace_settings.name = "Non-Color"
    values = numpy.empty(len(image.pixels), dtype=numpy.float32)
    image.pixels.foreach_get(values)
    return values.reshape(image.size[1], image.size[0], -1)[:, :, :3]


def bilinear(image, u, v):
    height, width = image.shape[:2]
    x, y = u * width - 0.5, v * height - 0.5
    i, j = int(numpy.floor(x)), int(numpy.floor(y))
    f, g = x - i, y - j
    row, below = image[j % height], image[(j + 1) % height]
    return ((1 - g) * ((1 - f) * row[i % width] + f * row[(i + 1) % width]) +
            g * ((1 - f) * below[i % width] + f * below[(i + 1) % width]))


bpy.ops.wm.read_factory_settings(use_empty=True)
low, high = load(low_file), load(high_file)
low.calc_tangents()
uvs = low.uv_layers.active.data
tree = BVHTree.FromPolygons([v.co for v in high.vertices], [tuple(p.vertices) for p in high.polygons])
images = [(name, kind, pixels(name)) for name, kind in (m.rsplit(":", 1) for m in maps)]
areas = numpy.cumsum([p.area for p in low.polygons])
generator = random.Random(1)
errors = [[] for _ in images]
for _ in range(POINTS):
    polygon = low.polygons[int(numpy.searchsorted(areas, generator.random() * areas[-1]))]
    a, b = sorted((generator.random(), generator.random()))
    weights = (a, b - a, 1 - b)
    mix = lambda values: sum((w * value for w, value in zip(weights, values)), Vector((0, 0, 0)))
    loops = [low.loops[i] for i in polygon.loop_indices]
    point = mix([low.vertices[l.vertex_index].co for l in loops])
    normal, tangent = mix([l.normal for l in loops]), mix([l.tangent for l in loops])
    u = sum(w * uvs[l.index].uv[0] for w, l in zip(weights, loops))
    v = sum(w * uvs[l.index].uv[1] for w, l in zip(weights, loops))
    outward = normal.normalized()
    place, _, face, _ = tree.ray_cast(point + REACH * outward, -outward, 2 * REACH)
    if face is None:
        continue
    corners = [high.vertices[i] for i in high.polygons[face].vertices]
    p, q, r = (c.co for c in corners)
    whole = (q - p).cross(r - p)
    share = [(r - q).cross(place - q).dot(whole), (p - r).cross(place - r).dot(whole),
             (q - p).cross(place - p).dot(whole)]
    truth = sum((s * c.normal for s, c in zip(share, corners)), Vector((0, 0, 0))).normalized()
    for (_, kind, image), found in zip(images, errors):
        c = bilinear(image, u, v)
        if kind == "encoded":
            c = 2 * c - 1
        decoded = (float(c[0]) * tangent + float(c[1]) * loops[0].bitangent_sign * normal.cross(tangent) +
                   float(c[2]) * normal)
        found.append(numpy.degrees(decoded.angle(truth, 0)))
for (name, _, _), found in zip(images, errors):
    found = numpy.array(found)
    print(f"angular error {name}: mean {found.mean():.3f} median {numpy.median(found):.3f} "
          f"95 % {numpy.percentile(found, 95):.3f} degrees, {100 * (found > 10).mean():.2f} % above 10, "
          f"{len(found)} points", flush=True)
