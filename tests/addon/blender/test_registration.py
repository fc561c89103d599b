"""The zip is installed, enabled, disabled and enabled again. Needs BLENDER_USER_* in a temporary folder."""
import importlib
import os
import runpy
import sys
import unittest

import addon_utils
import bpy
from support import ADDON, scene as s


def install(path):
    """Installs as this Blender does it; returns the module's name."""
    if hasattr(bpy.ops, "extensions") and bpy.app.version >= (4, 2, 0):
        addon_utils.extensions_refresh()
        bpy.ops.extensions.package_install_files(filepath=path, repo="user_default", enable_on_install=False)
        return "bl_ext.user_default.human_material"
    bpy.ops.preferences.addon_install(filepath=path)
    return "human_material"


class Registration(unittest.TestCase):
    def setUp(self):
        for kind in ("CONFIG", "SCRIPTS"):
            self.assertIn("BLENDER_USER_" + kind, os.environ, "set BLENDER_USER_%s to a temporary folder" % kind)
        if ADDON in sys.path:
            sys.path.remove(ADDON)   # only the installed copy may be found
        for name in [n for n in sys.modules if n.split(".")[0] == "human_material"]:
            del sys.modules[name]

    def test_install_enable_disable_enable(self):
        archive = os.path.join(s.folder(), "human_material.zip")
        runpy.run_path(os.path.join(ADDON, "tools", "build_zip.py"))["build"](archive)
        module = install(archive)
        importlib.invalidate_caches()
        for _ in range(2):
            bpy.ops.preferences.addon_enable(module=module)
            self.assertTrue(addon_utils.check(module)[1])
            self.assertTrue(hasattr(bpy.types.Scene, "hm"))
            self.assertFalse(sys.modules[module].__file__.startswith(ADDON))
            for name in ("HM_PT_maps", "HM_PT_light", "HM_PT_edit", "HM_PT_edit_hair", "HM_PT_render"):
                self.assertTrue(hasattr(bpy.types, name), name)
            self.assertAlmostEqual(bpy.context.scene.hm.strength, 1)
            bpy.ops.preferences.addon_disable(module=module)
            self.assertFalse(hasattr(bpy.types.Scene, "hm"))
            self.assertFalse(hasattr(bpy.types, "HM_PT_maps"))
