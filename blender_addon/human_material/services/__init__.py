# SPDX-License-Identifier: GPL-3.0-or-later
"""What the add-on can do, without its user interface.

Pure Python, testable without Blender: errors, maps_json, image_header, decode, grid, classes, presets, labelling.
With Blender (bpy): maps, material, relief, edit, lights, environment, camera, render.
"""
