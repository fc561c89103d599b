"""Where light comes from, and how much."""
import math
import unittest

import bpy
from mathutils import Vector
from support import maps_folder, scene as s

from human_material.services import environment, lights, relief, render

BUMP = maps_folder.Person(24, 24, maps_folder.ORTHOGRAPHIC)
FLAT = maps_folder.Person(16, 16, maps_folder.ORTHOGRAPHIC, flat=True)
PEAK, WIDTH = 4000.0, 64
#: solid angle of a texel at the horizon's first row
TEXEL = 2 * math.pi / WIDTH * (math.cos(math.pi / 2) - math.cos(math.pi / 2 + math.pi / (WIDTH / 2)))


class Legs(maps_folder.Person):
    """Two upright cylinders of 30 cm, their axes 50 cm apart on the centre plane."""

    def across(self, x, y):
        """From the nearer axis, in radii."""
        u = 80 * self.place(x, y)[0]
        return max(-1.0, min(1.0, (u - math.copysign(25, u)) / 15))

    def covered(self, x, y):
        return abs(self.across(x, y)) < 1 and abs(self.place(x, y)[1]) < 0.8

    def depth_cm(self, x, y):
        return 15 * math.sqrt(1 - self.across(x, y) ** 2)

    def normal(self, x, y):
        return (self.across(x, y), 0.0, math.sqrt(1 - self.across(x, y) ** 2))


class Ball(maps_folder.Person):
    """A ball, whose pixels hold what is covered of them: means of 8 x 8 points."""

    FINE = 8

    def points(self, x, y):
        """(u, v, w) of the points of a pixel that the ball covers, on a ball of radius 1."""
        result = []
        for j in range(self.FINE):
            for i in range(self.FINE):
                u, v = (c / maps_folder.RADIUS for c in self.place(x + (i + 0.5) / self.FINE - 0.5,
                                                                  y + (j + 0.5) / self.FINE - 0.5))
                if u * u + v * v < 1:
                    result.append((u, v, math.sqrt(1 - u * u - v * v)))
        return result

    def covered(self, x, y):
        return len(self.points(x, y)) > 0

    def depth_cm(self, x, y):
        points = self.points(x, y)
        return 0.5 * self.frame_cm * maps_folder.RADIUS * sum(p[2] for p in points) / max(1, len(points))

    def normal(self, x, y):
        return tuple(sum((Vector(p) for p in self.points(x, y)), Vector((0, 0, 0))).normalized())

    def maps(self):
        return {**super().maps(),
                "mask": self.raster(lambda x, y: len(self.points(x, y)) / self.FINE ** 2)}

    def shading(self, direction):
        """Of each pixel, times its coverage: 0.5 x cosine, what a sun of irradiance pi leaves of albedo 0.5."""
        return self.raster(lambda x, y: sum(0.5 * max(0.0, Vector(p).dot(direction)) for p in self.points(x, y))
                           / self.FINE ** 2)


class Light(unittest.TestCase):
    def setUp(self):
        self.scene = s.empty_scene()

    def matte(self, person):
        """A person of albedo 0.5 that only reflects diffusely."""
        item, loaded = s.import_person(self.scene, person)
        tree = relief.material_of(item).node_tree
        diffuse = tree.nodes.new("ShaderNodeBsdfDiffuse")
        diffuse.inputs["Color"].default_value = (0.5, 0.5, 0.5, 1)
        tree.links.new(s.source_of(s.socket_of(item, "normal")), diffuse.inputs["Normal"])
        end = next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL")
        tree.links.new(diffuse.outputs[0], end.inputs["Surface"])
        return loaded

    def halves(self, values, loaded):
        """Mean of the left, right, lower and upper half."""
        width, height = loaded.size
        sums = {"left": [], "right": [], "lower": [], "upper": []}
        for p in s.inside(loaded, 2):
            sums["left" if p % width < width / 2 else "right"].append(values[3 * p])
            sums["lower" if p // width < height / 2 else "upper"].append(values[3 * p])
        return {side: sum(v) / len(v) for side, v in sums.items()}

    def test_the_back_throws_a_shadow(self):
        """Light from the left and from behind passes behind the left leg's front: its back stops it."""
        person = Legs(64, 64, maps_folder.ORTHOGRAPHIC)
        item, _ = s.import_person(self.scene, person)
        s.light_up(self.scene, Vector((-1, 0, -0.35)).normalized())
        means = []
        for has_back in (True, False):
            if not has_back:
                tree = item.data.materials[1].node_tree
                mix = next(n for n in tree.nodes if n.type == "MIX_SHADER")
                tree.links.remove(mix.inputs[0].links[0])
                mix.inputs[0].default_value = 1   # clear for all rays
            picture = s.rendered(self.scene, 4, box=True)
            inner = [p for p in range(64 * 64) if 0.12 < person.place(p % 64, 0)[0] < 0.2 and 20 < p // 64 < 44]
            means.append(sum(picture[3 * p] for p in inner) / len(inner))
        self.assertGreater(means[1], 0.01)
        self.assertLess(means[0], 0.05 * means[1])

    def test_one_texel_lights_the_side_it_is_on(self):
        loaded = self.matte(BUMP)
        seen = {}
        for name, direction in (("+x", (1, 0, 0)), ("-x", (-1, 0, 0)), ("+y", (0, 1, 0)), ("+z", (0, 0, 1)),
                                ("-z", (0, 0, -1))):
            s.light_up(self.scene, direction, peak=PEAK)
            seen[name] = self.halves(s.rendered(self.scene, 16), loaded)
        self.assertGreater(seen["+x"]["right"], 5 * seen["+x"]["left"])
        self.assertGreater(seen["-x"]["left"], 5 * seen["-x"]["right"])
        self.assertGreater(seen["+y"]["upper"], 5 * seen["+y"]["lower"])
        self.assertAlmostEqual(seen["+z"]["left"] / seen["+z"]["right"], 1, delta=0.15)
        self.assertLess(max(seen["-z"].values()), 0.02 * seen["+z"]["left"])

    def test_rotation_turns_light_from_the_viewer_to_the_right(self):
        loaded = self.matte(BUMP)
        s.light_up(self.scene, (0, 0, 1), peak=PEAK, rotation_deg=90)
        turned = self.halves(s.rendered(self.scene, 32), loaded)
        s.light_up(self.scene, (1, 0, 0), peak=PEAK)
        direct = self.halves(s.rendered(self.scene, 32), loaded)
        for side in direct:
            self.assertAlmostEqual(turned[side], direct[side], delta=0.05 * direct["right"])
        environment.set_rotation(self.scene, -180)
        back = self.halves(s.rendered(self.scene, 32), loaded)
        self.assertGreater(back["left"], 5 * back["right"])

    def test_radiance_and_strength(self):
        """A flat face of albedo 0.5 under a white sky of radiance 1 shows 0.5; twice the strength, 1."""
        loaded = self.matte(FLAT)
        centre = s.inside(loaded, 3)
        s.light_up(self.scene, sky=1.0)
        for strength in (1.0, 2.0):
            environment.set_strength(self.scene, strength)
            found = s.rendered(self.scene, 32)
            mean = sum(found[3 * p] for p in centre) / len(centre)
            self.assertAlmostEqual(mean, 0.5 * strength, delta=0.02)

    def test_the_outline_is_lit_from_behind(self):
        """A ball under a light from behind and above: its outline shows what a ball of albedo 0.5 shows there."""
        ball = Ball(48, 48, {**maps_folder.ORTHOGRAPHIC, "width_cm": 40.0})
        item, loaded = s.import_person(self.scene, ball)
        direction = (0.0, 0.6, -0.8)
        environment.set_dark(self.scene)
        sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
        sun.data.angle, sun.data.energy = 0, math.pi
        sun.rotation_euler = Vector(lights.to_blender(direction)).to_track_quat("Z", "Y").to_euler()
        self.scene.collection.objects.link(sun)
        tree = relief.material_of(item).node_tree
        diffuse = tree.nodes.new("ShaderNodeBsdfDiffuse")
        diffuse.inputs["Color"].default_value = (0.5, 0.5, 0.5, 1)
        tree.links.new(s.source_of(s.socket_of(item, "normal")), diffuse.inputs["Normal"])
        tree.links.new(diffuse.outputs[0], next(n for n in tree.nodes if n.type == "MIX_SHADER").inputs[2])
        render.set_pixel_exact(self.scene, relief.material_of(item), True)
        found = s.rendered(self.scene, 64, box=True)
        wanted = ball.shading(direction)
        self.assertAlmostEqual(sum(found[::3]) / sum(wanted), 1, delta=0.2)

    def test_point_light_has_the_irradiance_of_its_intensity_at_1_m(self):
        loaded = self.matte(FLAT)
        environment.set_dark(self.scene)
        lights.add_point(self.scene, (0, 80, 200), 6.0)   # 2 m in front of the frame's middle
        found = s.rendered(self.scene, 16)
        width = loaded.size[0]
        middle = [p for p in s.inside(loaded, 3) if abs(p % width - 7.5) < 1 and abs(p // width - 7.5) < 1]
        mean = sum(found[3 * p] for p in middle) / len(middle)
        self.assertAlmostEqual(mean, 0.5 / math.pi * 6.0 / 4, delta=0.006)

    def test_point_light_stands_in_our_axes(self):
        item = lights.add_point(self.scene, (100, 220, 200), 1.0)
        for found, wanted in zip(item.location, (1.0, -2.0, 2.2)):
            self.assertAlmostEqual(found, wanted, places=5)

    def test_other_worlds_stay(self):
        mine = self.scene.world = bpy.data.worlds.new("mine")
        s.light_up(self.scene, sky=1.0)
        self.assertIn("mine", bpy.data.worlds)
        self.assertIsNot(self.scene.world, mine)
        images = len(bpy.data.images)
        s.light_up(self.scene, sky=2.0)   # again: the picture is replaced, not added
        self.assertEqual(len(bpy.data.images), images)
