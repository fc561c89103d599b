"""What the tests of the add-on share. Importing it makes `human_material` importable."""
import os
import shutil
import sys
import tempfile

TESTS = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
ROOT = os.path.dirname(os.path.dirname(TESTS))
ADDON = os.path.join(ROOT, "blender_addon")

sys.dont_write_bytecode = True
sys.path.insert(0, ADDON)


def temporary_folder(case):
    """A new folder, removed when the test case ends."""
    path = tempfile.mkdtemp(prefix="hm")
    case.addCleanup(shutil.rmtree, path, ignore_errors=True)
    return path
