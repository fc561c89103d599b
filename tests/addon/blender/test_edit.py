"""Edits change their class as asked and leave the rest alone."""
import unittest

import bpy
from support import maps_folder, scene as s

from human_material.services import classes, edit, presets, relief
from human_material.services.errors import InputError

PERSON = maps_folder.Person(48, 48)


class Edit(unittest.TestCase):
    def setUp(self):
        self.scene = s.empty_scene()
        self.item, self.loaded = s.import_person(self.scene, PERSON)
        self.material = relief.material_of(self.item)
        s.light_up(self.scene, (0.6, 0.48, 0.64), sky=0.5, peak=500)

    def apply(self, text):
        class_name, preset = presets.parse_edit(text)
        edit.apply(self.material, class_name, preset)

    def difference(self, before, after, class_name):
        """Mean absolute difference (inside the class, outside of it). Pixels beside a border are left out: the
        pixel filter mixes them."""
        c = classes.NAMES.index(class_name)
        width = PERSON.width
        parts = {True: [], False: []}
        for p in s.inside(self.loaded, 1):
            shares = {self.loaded.shares[4 * (p + v * width + u) + c] for u in (-1, 0, 1) for v in (-1, 0, 1)}
            share = shares.pop()
            if not shares and share in (0.0, 1.0):
                parts[share == 1.0].append(sum(abs(before[3 * p + i] - after[3 * p + i]) for i in range(3)) / 3)
        return [sum(parts[k]) / len(parts[k]) for k in (True, False)]

    def test_edits_stay_in_their_class(self):
        before = s.rendered(self.scene, 32)
        for text in ("fabric:shiny_leather", "hair:auburn", "fabric:red", "skin:#805040"):
            class_name = text.split(":")[0]
            self.apply(text)
            inside, outside = self.difference(before, s.rendered(self.scene, 32), class_name)
            self.assertGreater(inside, 5e-3, text)
            self.assertLess(outside, 1e-3, text)
            edit.reset(self.material, class_name)
        again = s.rendered(self.scene, 32)   # random walks differ in the last bits from run to run
        self.assertLess(max(abs(u - v) for u, v in zip(before, again)), 1e-5)

    def test_values_of_leather_arrive(self):
        self.apply("fabric:shiny_leather")
        fabric = [p for p in s.inside(self.loaded, 3) if self.loaded.shares[4 * p + 2] == 1]
        for meaning, wanted in (("roughness", 0.25), ("specular", presets.PRESETS["shiny_leather"].f0 / 0.08)):
            s.show(self.item, s.source_of(s.socket_of(self.item, meaning)))
            found = s.rendered(self.scene, 1, exact=True)
            for p in fabric:
                self.assertAlmostEqual(found[3 * p], wanted, delta=2e-3)

    def test_recolouring_has_the_asked_mean_and_keeps_the_texture(self):
        color = presets.color_of("#a32a2a")
        self.apply("fabric:#a32a2a")
        s.show(self.item, s.source_of(s.socket_of(self.item, "base")))
        found = s.rendered(self.scene, 1, exact=True)
        fabric = [p for p in s.inside(self.loaded, 3) if self.loaded.shares[4 * p + 2] == 1]
        for c in range(3):
            self.assertAlmostEqual(sum(found[3 * p + c] for p in fabric) / len(fabric), color[c], delta=0.01)

    def test_unknown_class_and_foreign_material(self):
        self.assertRaises(InputError, edit.apply, self.material, "wool", presets.PRESETS["red"])
        self.assertRaises(InputError, edit.apply, bpy.data.materials.new("mine"), "hair", presets.PRESETS["red"])
