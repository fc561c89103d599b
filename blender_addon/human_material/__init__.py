# SPDX-License-Identifier: GPL-3.0-or-later
"""Human Material: labels scans, relights and edits people from image-space material maps, in Blender 3.4 to 5.x.

    services/   what the add-on can do; no user interface, usable from scripts (blender_addon/relight.py)
    ui/         thin operators and panels; only this imports from services, never the other way round
    compat.py   every difference between Blender's versions
    data/       the table of materials and the presets of edits

One package for both kinds of installation: bl_info for Blender before 4.2, blender_manifest.toml from there.
Pure Python 3.10; NumPy makes large maps quicker where it is there.
"""
bl_info = {
    "name": "Human Material",
    "author": "The openhumanbrdf authors",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "3D Viewport > Sidebar > Human Material",
    "description": "Labels scans; relights and edits people from estimated maps",
    "category": "Render",
}


def register():
    from . import ui
    ui.register()


def unregister():
    from . import ui
    ui.unregister()
