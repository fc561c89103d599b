"""The package as a whole: manifest, versions, and the rules that keep it portable."""
import ast
import os
import re
import runpy
import unittest
import zipfile

from support import ADDON, ROOT, temporary_folder

try:
    import tomllib
except ImportError:   # Python 3.10
    tomllib = None

PACKAGE = os.path.join(ADDON, "human_material")
TAGS = {"3D View", "Add Curve", "Add Mesh", "Animation", "Bake", "Camera", "Compositing", "Development",
        "Game Engine", "Geometry Nodes", "Grease Pencil", "Import-Export", "Lighting", "Material", "Mesh",
        "Modeling", "Node", "Object", "Paint", "Pipeline", "Physics", "Render", "Rigging", "Scene", "Sculpt",
        "Sequencer", "System", "Text Editor", "Tracking", "User Interface", "UV"}


def sources():
    for folder, _, names in os.walk(PACKAGE):
        for name in names:
            if name.endswith(".py"):
                with open(os.path.join(folder, name), encoding="utf-8") as file:
                    yield os.path.relpath(os.path.join(folder, name), PACKAGE), file.read()


class Package(unittest.TestCase):
    def version(self):
        info = runpy.run_path(os.path.join(PACKAGE, "__init__.py"))["bl_info"]
        self.assertEqual(info["blender"], (3, 4, 0))
        return ".".join(map(str, info["version"]))

    def test_one_version_number(self):
        with open(os.path.join(ROOT, "CMakeLists.txt"), encoding="utf-8") as file:
            project = re.search(r"project\(\w+ VERSION ([\d.]+)", file.read()).group(1)
        self.assertEqual(self.version(), project)

    @unittest.skipIf(tomllib is None, "Python before 3.11 has no tomllib")
    def test_manifest(self):
        with open(os.path.join(PACKAGE, "blender_manifest.toml"), "rb") as file:
            manifest = tomllib.load(file)
        self.assertEqual(manifest["schema_version"], "1.0.0")
        self.assertEqual(manifest["version"], self.version())
        self.assertEqual(manifest["blender_version_min"], "4.2.0")
        self.assertEqual(manifest["license"], ["SPDX:GPL-3.0-or-later"])
        self.assertTrue(set(manifest["tags"]) <= TAGS)
        for text in (manifest["tagline"], *manifest["permissions"].values()):
            self.assertLessEqual(len(text), 64)
            self.assertRegex(text, r"[A-Za-z0-9)\]}]$")
        self.assertEqual(set(manifest["permissions"]), {"files"})   # no network

    def test_rules(self):
        for name, text in sources():
            with self.subTest(file=name):
                self.assertTrue(text.startswith("# SPDX-License-Identifier: GPL-3.0-or-later\n"))
                self.assertLess(text.count("\n"), 400)
                if name != "compat.py":
                    self.assertNotIn("app.version", text.replace("app.version_string", ""))
                tree = ast.parse(text, feature_version=(3, 10))
                for node in ast.walk(tree):
                    if isinstance(node, (ast.Import, ast.ImportFrom)):
                        modules = [a.name for a in node.names] if isinstance(node, ast.Import) else [node.module or ""]
                        for module in modules:
                            self.assertTrue("numpy" not in module or name == "services/vector.py", name)
                            self.assertFalse(module.startswith("human_material"), "import relatively")
                        if name.startswith("services"):
                            self.assertNotIn("ui", modules)

    def test_zip_is_reproducible_and_has_one_folder(self):
        build = runpy.run_path(os.path.join(ADDON, "tools", "build_zip.py"))["build"]
        folder = temporary_folder(self)
        content = []
        for name in ("a.zip", "b.zip"):
            build(os.path.join(folder, name))
            with open(os.path.join(folder, name), "rb") as file:
                content.append(file.read())
        self.assertEqual(content[0], content[1])
        with zipfile.ZipFile(os.path.join(folder, "a.zip")) as archive:
            names = archive.namelist()
        self.assertEqual({name.split("/")[0] for name in names}, {"human_material"})
        for needed in ("__init__.py", "blender_manifest.toml", "compat.py", "data/presets.json", "LICENSE"):
            self.assertIn("human_material/" + needed, names)
