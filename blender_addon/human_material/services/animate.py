# SPDX-License-Identifier: GPL-3.0-or-later
"""Drivers from the panel's settings (scene.hm) to what they set: so that keyframes on the settings work, which call no
update functions."""
import math

SETTINGS = "hm"


def drive(owner, path, index, scene, setting, factor=1.0):
    """owner.path[index] (index -1: no array) follows factor x scene.hm.setting. Does nothing where the panel is not
    registered, as in scripts that set the values themselves."""
    if not hasattr(scene, SETTINGS):
        return
    owner.driver_remove(path, *([index] if index >= 0 else []))
    curve = owner.driver_add(path, *([index] if index >= 0 else []))
    driver = curve.driver
    variable = driver.variables.new()
    variable.name = "v"
    variable.type = "SINGLE_PROP"
    target = variable.targets[0]
    target.id_type = "SCENE"
    target.id = scene
    target.data_path = "%s.%s" % (SETTINGS, setting)
    driver.type = "SCRIPTED"
    driver.expression = "v" if factor == 1.0 else "v * %.9g" % factor   # simple: runs where scripts may not


def environment(scene, nodes, mapping, background):
    """The world follows Rotation and Strength."""
    tree = nodes[mapping].id_data
    drive(tree, 'nodes["%s"].inputs["Rotation"].default_value' % mapping, 2, scene, "rotation_deg",
          -math.radians(1))
    drive(tree, 'nodes["%s"].inputs["Strength"].default_value' % background, -1, scene, "strength")


def subsurface(scene, material, node):
    """A person's material follows the factor on the subsurface map."""
    drive(material.node_tree, 'nodes["%s"].inputs[1].default_value' % node, -1, scene, "subsurface_scale")
