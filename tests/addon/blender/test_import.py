"""A maps folder in the scene: depth, camera, normals, encodings."""
import math
import os
import unittest
from types import SimpleNamespace

import bpy
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Vector
from support import image_files, maps_folder, scene as s, temporary_folder

from human_material.services import maps, relief
from human_material.services.errors import InputError

WIDE = maps_folder.Person(40, 24, dict(maps_folder.ORTHOGRAPHIC))
TALL = maps_folder.Person(20, 32, dict(maps_folder.PERSPECTIVE))
SQUARE = maps_folder.Person(32, 32)


class Import(unittest.TestCase):
    def setUp(self):
        self.scene = s.empty_scene()

    def test_every_vertex_projects_into_its_pixel_at_its_depth(self):
        for person in (SQUARE, WIDE, TALL, maps_folder.Person(16, 16, maps_folder.ORTHOGRAPHIC),
                       maps_folder.Person(16, 40, maps_folder.ORTHOGRAPHIC)):
            scene = s.empty_scene()
            item, loaded = s.import_person(scene, person)
            bpy.context.view_layer.update()
            uv = [None] * len(item.data.vertices)
            for loop, corner in zip(item.data.loops, item.data.uv_layers[0].data):
                uv[loop.vertex_index] = corner.uv
            front = s.front_vertex_count(item)   # the back's come last
            used = [v for v in item.data.vertices if uv[v.index] is not None and v.index < front]
            self.assertGreater(len(used), 100)
            for vertex in used:
                seen = world_to_camera_view(scene, scene.camera, item.matrix_world @ vertex.co)
                self.assertLess(abs(seen.x - uv[vertex.index][0]) * person.width, 1e-3)
                self.assertLess(abs(seen.y - uv[vertex.index][1]) * person.height, 1e-3)
                x = int(uv[vertex.index][0] * person.width)
                y = person.height - 1 - int(uv[vertex.index][1] * person.height)
                if person.covered(x, y):
                    self.assertAlmostEqual(vertex.co.z * 100, person.depth_cm(x, y), delta=1e-4)

    def test_alpha_is_the_fourth_of_four_shares_and_else_ignored(self):
        shares = [(0.5, 0.25, 0.0, 0.125), (0.0, 0.0, 1.0, 0.0), (0.25, 0.0, 0.25, 0.5), (0.0, 0.0, 0.0, 1.0)]
        codes = [round(65535 * v) for pixel in shares for v in pixel]
        for name, write in (("x.exr", lambda path: image_files.exr(path, 4, 1, sum(shares, ()), "RGBA")),
                            ("x.png", lambda path: image_files.png(path, 4, 1, codes, 3, 16, True))):
            path = os.path.join(temporary_folder(self), name)
            write(path)
            for channels in (3, 4):
                found = maps.read_raster(path, channels, 4, 1)
                for k, pixel in enumerate(shares):
                    for c in range(channels):
                        self.assertAlmostEqual(found[channels * k + c], pixel[c], delta=1e-4)
            asked = SimpleNamespace(name="classes", path=path, kinds=("PNG", "EXR"), encoding="shares", channels=4)
            maps._checked_header(asked, SimpleNamespace(width_px=4, height_px=1))
        image_files.exr(path, 4, 1, [0.5] * 12)
        with self.assertRaisesRegex(InputError, "has 3 channel, 4 are needed"):
            maps._checked_header(asked, SimpleNamespace(width_px=4, height_px=1))

    def test_stands_in_the_world(self):
        item, _ = s.import_person(self.scene, SQUARE)
        bpy.context.view_layer.update()
        towards_viewer = item.matrix_world.to_3x3() @ Vector((0, 0, 1))
        self.assertLess((towards_viewer - Vector((0, -1, 0))).length, 1e-6)
        self.assertAlmostEqual(item.location.z, 0.8, places=6)
        self.assertAlmostEqual(self.scene.camera.location.y, -4, places=5)

    def test_camera_sees_the_source_picture(self):
        for person in (SQUARE, WIDE):
            scene = s.empty_scene()
            item, loaded = s.import_person(scene, person)
            s.show(item, relief.material_of(item).node_tree.nodes["HM_diffuse"].outputs["Color"])
            found = s.rendered(scene, 1, exact=True)
            worst = max(abs(found[3 * p + c] - loaded.diffuse[3 * p + c])
                        for p in s.inside(loaded, 1) for c in range(3))
            self.assertLess(worst, 2e-3)   # bilinear texels, 0.01 pixel off the centre

    def test_normals_within_a_hundredth_of_a_degree(self):
        item, loaded = s.import_person(self.scene, SQUARE)
        tree = relief.material_of(item).node_tree
        shifted = tree.nodes.new("ShaderNodeVectorMath")
        shifted.operation = "MULTIPLY_ADD"
        shifted.inputs[1].default_value = shifted.inputs[2].default_value = (0.5, 0.5, 0.5)
        tree.links.new(s.source_of(s.socket_of(item, "normal")), shifted.inputs[0])
        s.show(item, shifted.outputs[0])
        found = s.rendered(self.scene, 1, exact=True)
        angles = []
        for p in s.inside(loaded, 1):
            world = Vector([2 * v - 1 for v in found[3 * p:3 * p + 3]]).normalized()
            nx, ny, nz = loaded.normal[3 * p:3 * p + 3]
            wanted = Vector((nx, -nz, ny))
            angles.append(math.degrees(math.atan2(world.cross(wanted).length, world.dot(wanted))))
        self.assertLess(sum(angles) / len(angles), 0.01)

    def test_png_and_exr_hold_the_same(self):
        path = s.folder()
        maps_folder.write(os.path.join(path, "exr"), SQUARE)
        maps_folder.write_png(os.path.join(path, "png"), SQUARE)
        a, b = maps.load(os.path.join(path, "exr")), maps.load(os.path.join(path, "png"))
        for name, tolerance in (("mask", 1e-4), ("normal", 1e-4), ("diffuse", 1e-4), ("roughness", 1e-4),
                                ("f0", 1e-4), ("sss", 1e-4), ("displacement_cm", 0.01), ("shares", 0.01)):
            u, v = getattr(a, name), getattr(b, name)
            n = len(u) // len(a.mask)
            worst = max(abs(u[i] - v[i]) for p in range(len(a.mask)) if a.known[p] for i in range(p * n, p * n + n))
            self.assertLess(worst, tolerance, name)
        self.assertEqual(b.warnings, [])
        maps_folder.write_png(os.path.join(path, "png8"), SQUARE, bits=8)
        self.assertEqual(len(maps.load(os.path.join(path, "png8")).warnings), 2)

    def test_classes_map_counts_where_there_is_one(self):
        path = s.folder()
        share = SQUARE.raster(lambda x, y: (0.25, 0.5, 0.0))
        maps_folder.write(path, SQUARE, {"classes": share})
        loaded = maps.load(path)
        p = s.inside(loaded)[0]
        self.assertEqual(list(loaded.shares[4 * p:4 * p + 4]), [0.25, 0.25, 0.5, 0.0])

    def test_leaves_no_picture_of_the_files_behind(self):
        before = len(bpy.data.images)
        s.import_person(self.scene, SQUARE)
        self.assertEqual(len(bpy.data.images), before + 4)

    def test_survives_saving(self):
        """The pictures are in the .blend."""
        item, loaded = s.import_person(self.scene, SQUARE)
        name = item.name
        path = os.path.join(s.folder(), "scene.blend")
        bpy.ops.wm.save_as_mainfile(filepath=path)
        bpy.ops.wm.open_mainfile(filepath=path)
        image = relief.material_of(bpy.data.objects[name]).node_tree.nodes["HM_rss"].image
        values = [0.0] * (4 * 32 * 32)
        image.pixels.foreach_get(values)
        self.assertLess(max(abs(u - v) for u, v in zip(values[1::4], loaded.f0)), 1e-7)
