"""compat.py against stand-ins for the versions of Blender that are not here."""
import importlib
import sys
import types
import unittest

import support  # noqa: F401


class Sockets(dict):
    def __iter__(self):
        return iter(self.values())


def principled(names):
    node = types.SimpleNamespace(distribution="MULTI_GGX", subsurface_method="?")
    node.inputs = Sockets((n, types.SimpleNamespace(name=n, default_value=0)) for n in names)
    return node


OLD = ("Base Color", "Subsurface", "Subsurface Radius", "Subsurface Color", "Specular", "Roughness", "IOR", "Normal")
NEW = ("Base Color", "Roughness", "IOR", "Normal", "Subsurface Weight", "Subsurface Radius", "Subsurface Scale",
       "Specular IOR Level")


class Compat(unittest.TestCase):
    def load(self, version):
        sys.modules["bpy"] = types.SimpleNamespace(app=types.SimpleNamespace(version=version))
        self.addCleanup(sys.modules.pop, "bpy", None)
        sys.modules.pop("human_material.compat", None)
        self.addCleanup(sys.modules.pop, "human_material.compat", None)
        return importlib.import_module("human_material.compat")

    def test_subsurface_map_is_a_scale_in_both_generations(self):
        for version, names, scale, weight in (((3, 4, 1), OLD, "Subsurface", None),
                                              ((4, 5, 0), NEW, "Subsurface Scale", 1.0)):
            compat = self.load(version)
            node = principled(names)
            compat.prepare_principled(node)
            self.assertEqual(compat.principled_socket(node, "subsurface_scale").name, scale)
            self.assertEqual(node.inputs["IOR"].default_value, 1.5)
            self.assertEqual(node.distribution, "GGX")
            if weight is not None:
                self.assertEqual(node.inputs["Subsurface Weight"].default_value, weight)
                self.assertIsNone(compat.principled_socket(node, "subsurface_color"))
            self.assertIn("Specular", compat.principled_socket(node, "specular").name)

    def test_random_walk_by_meaning(self):
        compat = self.load((3, 4, 1))
        for version, fixed, skin in (((3, 4), "RANDOM_WALK_FIXED_RADIUS", "RANDOM_WALK"),
                                     ((4, 0), "RANDOM_WALK", "RANDOM_WALK_SKIN"),
                                     ((5, 1), "RANDOM_WALK", "RANDOM_WALK_SKIN"),
                                     ((5, 2), "RANDOM_WALK_LEGACY", "RANDOM_WALK_SKIN")):
            self.assertEqual(compat.subsurface_identifier("random_walk_fixed", version), fixed)
            self.assertEqual(compat.subsurface_identifier("random_walk_skin", version), skin)
            self.assertEqual(compat.subsurface_identifier("burley", version), "BURLEY")

    def test_group_sockets(self):
        compat = self.load((4, 0, 0))
        made = []
        new = types.SimpleNamespace(interface=types.SimpleNamespace(
            new_socket=lambda name, in_out, socket_type: made.append((name, in_out, socket_type))))
        compat.new_group_socket(new, "F0", "INPUT", "NodeSocketFloat")
        old = types.SimpleNamespace(inputs=types.SimpleNamespace(new=lambda kind, name: made.append((name, kind))))
        compat.new_group_socket(old, "F0", "INPUT", "NodeSocketFloat")
        self.assertEqual(made, [("F0", "INPUT", "NodeSocketFloat"), ("F0", "NodeSocketFloat")])

    def test_generation(self):
        self.assertEqual(self.load((3, 6, 9)).generation(), "principled_v1")
        self.assertEqual(self.load((5, 2, 0)).generation(), "principled_v2")
