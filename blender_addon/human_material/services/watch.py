# SPDX-License-Identifier: GPL-3.0-or-later
"""What the add-on does when something changes in the scene: moving the value of an edit raises its amount, and a copy
of a person gets a material of its own."""
import bpy

from . import edit, relief

#: value of an edit -> its amount
AMOUNT_OF = {"Color": "Color Amount", "Roughness": "Roughness Amount", "F0": "Specular Amount",
             "Subsurface": "Subsurface Amount"}

_seen = {}   # (material, class) -> the values when they were last looked at


def _values(node):
    return {name: tuple(value) if hasattr(value, "__len__") else value
            for name, value in ((name, node.inputs[name].default_value) for name in AMOUNT_OF)}


def raise_amounts(material):
    """A value that was moved while its amount was 0 gets the amount 1: else it would do nothing. Not one that was
    moved back to where it is without an edit (Reset)."""
    for class_name, node in edit.nodes_of(material).items():
        values, imported = _values(node), edit.values_as_imported(edit.class_of(class_name))
        before = _seen.get((material.name_full, class_name), imported)
        _seen[material.name_full, class_name] = values
        for name, amount in AMOUNT_OF.items():
            if values[name] not in (before[name], imported[name]) and node.inputs[amount].default_value == 0:
                node.inputs[amount].default_value = 1.0


def part_copies(scene):
    """A copy of a person (not a linked one) gets its own material, so that edits of one leave the other alone."""
    owner = {}
    for item in relief.reliefs(scene):
        skin = relief.material_of(item)
        if skin is None:
            continue
        first = owner.setdefault(skin.name_full, item.data)
        if first is not item.data:
            item.data.materials[0] = skin.copy()
            item.data.materials[0].name = item.name


def forget():
    """After undo, redo and loading the values are what they are: nobody moved them."""
    _seen.clear()
    for material in bpy.data.materials:
        for class_name, node in edit.nodes_of(material).items():
            _seen[material.name_full, class_name] = _values(node)


@bpy.app.handlers.persistent
def _on_change(scene, depsgraph):
    touched = {update.id.bl_rna.identifier for update in depsgraph.updates if update.id is not None}
    if touched & {"Material", "ShaderNodeTree"}:
        for item in relief.reliefs(scene):
            skin = relief.material_of(item)
            if skin is not None:
                raise_amounts(skin)
    if touched & {"Object", "Mesh"}:
        part_copies(scene)


@bpy.app.handlers.persistent
def _on_jump(*_):
    forget()


_HANDLERS = (("depsgraph_update_post", _on_change), ("undo_post", _on_jump), ("redo_post", _on_jump),
             ("load_post", _on_jump))


def register():
    for name, handler in _HANDLERS:
        getattr(bpy.app.handlers, name).append(handler)


def unregister():
    for name, handler in _HANDLERS:
        handlers = getattr(bpy.app.handlers, name)
        if handler in handlers:
            handlers.remove(handler)
    _seen.clear()
