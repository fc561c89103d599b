"""Runs the tests of this folder inside Blender, or in Python with the bpy module:

    blender -b -noaudio --factory-startup --python-exit-code 1 --python run.py -- [test_import ...]
    python run.py [test_import ...]

NumPy is blocked: the add-on must do without it. Ends with `N passed, N failed, N skipped`; exits 1 on a failure.
"""
import os
import sys
import unittest

sys.modules["numpy"] = None
sys.dont_write_bytecode = True
HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, HERE)
sys.path.insert(0, os.path.dirname(HERE))

import bpy  # noqa: E402,F401
import support  # noqa: E402,F401
from support import scene  # noqa: E402

DEFAULT = ("test_import", "test_material", "test_light", "test_edit", "test_bad_input", "test_guest",
           "test_relight", "test_garments", "test_studio", "test_files", "test_label", "test_label_faults", "test_tools")


def main(names):
    loader = unittest.defaultTestLoader
    suite = unittest.TestSuite(loader.loadTestsFromName(name) for name in (names or DEFAULT))
    result = unittest.TextTestRunner(verbosity=2, stream=sys.stdout).run(suite)
    failed = len(result.failures) + len(result.errors)
    skipped = len(result.skipped)
    print("Blender %s: %d passed, %d failed, %d skipped"
          % (bpy.app.version_string, result.testsRun - failed - skipped, failed, skipped), flush=True)
    scene.remove_folders()
    return failed > 0 or result.testsRun == 0


if __name__ == "__main__":
    inside_blender = bool(bpy.app.binary_path)
    arguments = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else [] if inside_blender else sys.argv[1:]
    status = int(main(arguments))
    if not inside_blender:
        os._exit(status)   # some bpy modules crash when Python ends
    sys.exit(status)
