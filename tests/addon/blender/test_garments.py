"""Edits of one garment: found by colour and place, and nothing changes outside of it."""
import bpy
from support import maps_folder, scene as s

from human_material.services import edit, garment_edit, presets, relief
from human_material.services.errors import InputError


class Dressed(maps_folder.Person):
    """All fabric but the head, which is skin: a blue shirt above grey trousers; no hair and no leather."""

    def class_of(self, x, y):
        return 0 if self.place(x, y)[1] > 0.4 else 2

    def color(self, x, y):
        shade = 0.9 + 0.2 * ((x + y) % 2)   # a weave
        base = (0.6, 0.4, 0.3) if self.class_of(x, y) == 0 else (0.1, 0.2, 0.6) if self.place(x, y)[1] > -0.1 else (
            0.35, 0.35, 0.35)
        return tuple(c * shade for c in base)

    def maps(self):
        return {**super().maps(), "diffuse": self.raster(self.color)}


class Garments(s.Registered):
    def setUp(self):
        super().setUp()
        self.item, self.loaded = s.import_person(self.scene, Dressed(48, 48))
        self.skin = relief.material_of(self.item)
        self.item.select_set(True)
        bpy.context.view_layer.objects.active = self.item

    def test_shirt_trousers_and_head_are_three(self):
        found = garment_edit.all_of(self.skin)
        self.assertEqual([class_name for _, class_name, _ in found].count("fabric"), 2)
        self.assertEqual(len(found), 3)
        shirt = garment_edit.garment_at(self.skin, 0.5, 0.55)
        trousers = garment_edit.garment_at(self.skin, 0.5, 0.3)
        self.assertEqual((shirt[1], trousers[1]), ("fabric", "fabric"))
        self.assertNotEqual(shirt[0], trousers[0])
        with self.assertRaisesRegex(InputError, "click on the person"):
            garment_edit.garment_at(self.skin, 0.02, 0.02)

    def test_nothing_changes_outside_the_garment(self):
        number = garment_edit.garment_at(self.skin, 0.5, 0.55)[0]
        numbers, width, _ = garment_edit.numbers_of(self.skin)
        s.light_up(self.scene, (0.6, 0.48, 0.64), sky=0.5, peak=500)
        before = s.rendered(self.scene, 32, box=True)
        bpy.ops.hm.edit_garment(garment=number)
        same = s.rendered(self.scene, 32, box=True)
        self.assertLess(max(abs(a - b) for a, b in zip(before, same)), 1e-4)   # not edited yet
        bpy.ops.hm.apply_preset(class_name="fabric", garment=number, preset="red")
        after = s.rendered(self.scene, 32, box=True)
        parts = {True: [], False: []}
        for p in s.inside(self.loaded, 1):
            around = {numbers[p + v * width + u] == number for u in (-1, 0, 1) for v in (-1, 0, 1)}
            if len(around) == 1:
                parts[around.pop()].append(sum(abs(before[3 * p + c] - after[3 * p + c]) for c in range(3)) / 3)
        self.assertGreater(sum(parts[True]) / len(parts[True]), 0.05)
        self.assertLess(sum(parts[False]) / len(parts[False]), 1e-3)
        bpy.ops.hm.reset_edit(class_name="fabric", garment=number)
        again = s.rendered(self.scene, 32, box=True)
        self.assertLess(max(abs(a - b) for a, b in zip(before, again)), 1e-4)

    def test_a_garment_that_becomes_white_is_white(self):
        number = garment_edit.garment_at(self.skin, 0.5, 0.55)[0]
        key, _ = garment_edit.node_for(self.skin, number)
        edit.apply(self.skin, key, presets.PRESETS["white"])
        s.show(self.item, s.source_of(s.socket_of(self.item, "base")))
        numbers, width, _ = garment_edit.numbers_of(self.skin)
        found = s.rendered(self.scene, 1, exact=True)
        inside = [p for p in s.inside(self.loaded, 2) if all(numbers[p + v * width + u] == number
                                                             for u in (-2, 0, 2) for v in (-2, 0, 2))]
        for c, wanted in enumerate(presets.PRESETS["white"].color):
            self.assertAlmostEqual(sum(found[3 * p + c] for p in inside) / len(inside), wanted, delta=0.03)

    def test_two_garments_have_edits_of_their_own(self):
        shirt, trousers = (garment_edit.garment_at(self.skin, 0.5, v)[0] for v in (0.55, 0.3))
        for number, preset in ((shirt, "red"), (trousers, "green")):
            bpy.ops.hm.apply_preset(class_name="fabric", garment=number, preset=preset)
        s.show(self.item, s.source_of(s.socket_of(self.item, "base")))
        found = s.rendered(self.scene, 1, exact=True)
        at = [3 * (int(v * 48) * 48 + 24) for v in (0.55, 0.3)]
        self.assertGreater(found[at[0]], 2 * found[at[0] + 1])       # red
        self.assertGreater(found[at[1] + 1], 2 * found[at[1]])       # green

    def test_an_absent_class_is_said(self):
        with self.assertRaisesRegex(RuntimeError, "no leather was found.*edit skin or fabric"):
            bpy.ops.hm.apply_preset(class_name="leather", preset="red")
        self.assertEqual(edit.node_of(self.skin, "leather").inputs["Color Amount"].default_value, 0)
