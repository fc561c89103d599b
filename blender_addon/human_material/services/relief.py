# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts the person of a maps folder into the scene: mesh, material, camera.

World: Blender's, metres, +Z up, soles at z = 0; ours (x, y, z) in cm is (x, -z, y) / 100. The relief stands upright,
its middle at camera.center_y_cm, and faces -Y, where the camera is.
"""
import math

import bpy
from mathutils import Vector

from .. import compat
from . import back, camera, grid, maps, material, vector

PROPERTY = "hm_maps"   # custom property of reliefs: the maps folder


def load_into(scene, path, jump_cm=grid.DEFAULT_JUMP_CM, match_camera=True, subsurface_method="random_walk_skin"):
    """Imports a maps folder. Returns (object, Maps). Throws InputError before anything is changed."""
    loaded = maps.load(path)
    relief = grid.build(loaded.displacement_cm, loaded.known, *loaded.size, loaded.info.camera, jump_cm)
    name = loaded.info.name
    normals = normals_of(relief, loaded)
    first_rear = len(relief.faces)
    add_rear(relief, normals, back.build(loaded))
    item = bpy.data.objects.new(name, mesh_of(relief, name))
    compat.set_vertex_normals(item.data, normals)
    item.data.polygons.foreach_set("material_index", [int(k >= first_rear) for k in range(len(relief.faces))])
    skin = material.build(loaded, name, subsurface_method)
    material.set_visible_scattering(skin, loaded.info.camera.frame_width_cm / loaded.info.width_px)
    item.data.materials.append(skin)
    item.data.materials.append(material.build_rear(skin, name))
    item.rotation_euler = (math.pi / 2, 0, 0)   # the camera's axes, stood upright
    item.location = (place_beside(scene, item), 0, loaded.info.camera.center_y_cm * grid.CM)
    item[PROPERTY] = loaded.info.folder
    scene.collection.objects.link(item)
    camera.remember(item, loaded.info)
    if match_camera:
        camera.match(scene, item)
    return item, loaded


def add_rear(relief, normals, rear):
    """The back's own vertices and faces; its normals are those of its faces."""
    count = len(relief.vertices)
    relief.vertices += rear.vertices
    relief.uvs += rear.uvs
    relief.faces += [tuple(count + v for v in face) for face in rear.faces]
    normals += [(0.0, 0.0, 0.0)] * len(rear.vertices)


GAP_M = 0.2   # between two persons


def place_beside(scene, item):
    """Where a new person's origin goes along X: the first at 0, another to the right of those that are there."""
    right = [(other.matrix_basis @ Vector(corner)).x for other in reliefs(scene) for corner in other.bound_box]
    return max(right) + GAP_M - min(corner[0] for corner in item.bound_box) if right else 0.0


def hide_default_cube(scene, item):
    """Blender's start-up cube stands where the person does: it is hidden, not removed. Returns its name, or None."""
    cube = scene.objects.get("Cube")
    if cube is None or cube.type != "MESH" or len(cube.data.vertices) != 8 or cube.location.length > 1e-4:
        return None
    if cube.hide_render or item.location.x != 0:
        return None
    cube.hide_render = True
    cube.hide_set(True)
    return cube.name


def mesh_of(relief, name):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(relief.vertices, [], relief.faces)
    layer = mesh.uv_layers.new(name="UVMap")
    corners = [0] * len(mesh.loops)
    mesh.loops.foreach_get("vertex_index", corners)
    if vector.np:
        layer.data.foreach_set("uv", vector.np.array(relief.uvs, "f")[corners].ravel())
    else:
        layer.data.foreach_set("uv", [value for v in corners for value in relief.uvs[v]])
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    mesh.update()
    return mesh


def normals_of(relief, loaded):
    """The map's normal at each vertex. Cycles asks the mesh, too, from which side light may come: by its faces alone
    the outline stays dark under light from behind."""
    width, height = loaded.size
    if vector.np:
        uv = vector.np.array(relief.uvs)
        x, y = ((uv[:, k] * n).astype(int).clip(0, n - 1) for k, n in ((0, width), (1, height)))
        return vector.view(loaded.normal, 3)[y * width + x].tolist()
    normals = []
    for u, v in relief.uvs:
        at = 3 * (min(int(v * height), height - 1) * width + min(int(u * width), width - 1))
        normals.append(tuple(loaded.normal[at:at + 3]))
    return normals


def is_relief(item):
    return item is not None and item.type == "MESH" and PROPERTY in item


def reliefs(scene):
    return [item for item in scene.objects if is_relief(item)]


def material_of(item):
    """The relief's material, or None."""
    if not is_relief(item) or not item.data.materials:
        return None
    found = item.data.materials[0]
    return found if material.is_ours(found) else None
