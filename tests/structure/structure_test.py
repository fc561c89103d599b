"""The source tree keeps its order: libraries, namespaces, sizes. And each check finds what it is for.

usage: structure_test.py SOURCE_FOLDER [unittest's arguments]
"""
import sys
import tempfile
import unittest
from pathlib import Path

import structure

ROOT = Path(sys.argv.pop(1)).resolve() if len(sys.argv) > 1 else Path(__file__).resolve().parents[2]
HEAD = "| folder | holds | uses |\n|---|---|---|\n"
MOST_LONG_FUNCTIONS = 8    # above 40 lines: to become fewer


class Tree(unittest.TestCase):
    def nothing(self, lines):
        self.assertFalse(lines, "\n" + "\n".join(lines))

    def test_includes_follow_the_link_graph(self):
        self.nothing(structure.wrong_includes(ROOT))

    def test_readme_says_what_links_what(self):
        self.nothing(structure.wrong_in_readme(ROOT))

    def test_each_library_has_a_namespace_of_its_own(self):
        self.nothing(structure.wrong_namespaces(ROOT))

    def test_no_two_types_have_one_name(self):
        self.assertGreater(sum(len(list(structure.types_of(structure.read(path)))) for path, _ in structure.files_of(ROOT)
                               if path.suffix in structure.SOURCES), 400)
        self.nothing(structure.types_of_one_name(ROOT))

    def test_files_and_functions_are_short(self):
        self.nothing(structure.too_long(ROOT))

    def test_no_definition_holds_a_path(self):
        self.nothing(structure.paths_in_definitions(ROOT))

    def test_no_place_writes_the_classes_out(self):
        self.nothing(structure.classes_written_out(ROOT))

    def test_few_functions_are_above_40_lines(self):
        found = structure.long_functions(ROOT, 40)
        self.assertLessEqual(len(found), MOST_LONG_FUNCTIONS, "\n" + "\n".join(found))


class Planted(unittest.TestCase):
    """A small tree that is in order, with one fault at a time."""

    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.root = Path(self.temporary.name)
        self.write("CMakeLists.txt", "add_subdirectory(low)\nadd_subdirectory(side)\nadd_subdirectory(high)\n")
        for name, links in (("low", ""), ("side", "PUBLIC low_lib"), ("high", "PRIVATE low_lib")):
            self.write(name + "/CMakeLists.txt",
                       "add_library(%s_lib STATIC x.cpp)\ntarget_link_libraries(%s_lib %s)\n" % (name, name, links))
            self.write(name + "/a.h", "namespace ohb::%s {\n}  // namespace ohb::%s\n" % (name, name))
        for top in ("dataset", "bake", "renderer", "learner", "blender_addon", "tests"):
            (self.root / top).mkdir()

    def write(self, name, text):
        (self.root / name).parent.mkdir(parents=True, exist_ok=True)
        (self.root / name).write_text(text)

    def test_a_tree_in_order_is_clean(self):
        self.write("high/b.cpp", '#include "low/a.h"\n')
        for check in (structure.wrong_includes, structure.wrong_namespaces, structure.too_long):
            self.assertEqual(check(self.root), [])

    def test_an_include_upwards(self):
        self.write("low/b.cpp", '#include "high/a.h"\n')
        self.assertEqual(len(structure.wrong_includes(self.root)), 1)

    def test_an_include_of_what_is_not_linked(self):
        self.write("high/b.cpp", '#include "side/a.h"\n')
        self.assertEqual(structure.wrong_includes(self.root),
                         ["high/b.cpp: includes side/a.h, whose library side is not linked by high"])

    def test_a_link_upwards(self):
        self.write("low/CMakeLists.txt", "add_library(low_lib STATIC x.cpp)\ntarget_link_libraries(low_lib PUBLIC high_lib)\n")
        self.assertEqual(len(structure.wrong_includes(self.root)), 1)

    def test_a_readme_that_is_behind(self):
        self.write("README.md", HEAD + "| `low` | holds | |\n| `side` | holds | `low` |\n| `high` | holds | `low` |\n")
        self.assertEqual(structure.wrong_in_readme(self.root), [])
        self.write("README.md", HEAD + "| `low` | holds | |\n| `side` | holds | |\n")
        self.assertEqual(len(structure.wrong_in_readme(self.root)), 2)

    def test_another_librarys_namespace(self):
        self.write("low/b.h", "namespace ohb::high {\n}\n")
        self.assertTrue(structure.wrong_namespaces(self.root))

    def test_two_types_of_one_name(self):
        own = "namespace {\nstruct B {};\n}  // namespace\n"
        self.write("dataset/a.h", "namespace ohb::low {\nstruct A;\nclass alignas(32) B final : public C {\n};\n}  // namespace ohb::low\n")
        self.write("bake/b.cpp", "namespace ohb::low {\n" + own + "enum class A { kOne };\n}  // namespace ohb::low\n")
        self.assertEqual(structure.types_of_one_name(self.root), [])
        self.write("bake/c.cpp", "namespace ohb {\nnamespace low {\nstruct B {};\n}  // namespace low\n}  // namespace ohb\n")
        self.assertEqual(structure.types_of_one_name(self.root), ["ohb::low::B is defined in dataset/a.h and bake/c.cpp"])

    def test_a_path_in_a_definition(self):
        self.write("tests/CMakeLists.txt", 'target_compile_definitions(t PRIVATE A=1 B="${PROJECT_SOURCE_DIR}"\n'
                                           '                           C="$<TARGET_FILE:t>")\n')
        self.assertEqual(structure.paths_in_definitions(self.root),
                         ['tests/CMakeLists.txt: B="${PROJECT_SOURCE_DIR', 'tests/CMakeLists.txt: C="$<TARGET_FILE'])

    def test_classes_that_are_written_out(self):
        self.write("dataset/a.cpp", "sum = best[f][0] + best[f][1] + best[f][2] + best[f][3];\nlength = v[0] + v[1] + v[2];\n")
        self.write("dataset/b.cpp", "garment = of[kFabric] + of[kLeather];\nskin = of[kSkin];\n")
        self.write("blender_addon/c.py", 'CLASSES = ("skin", "hair", "fabric", "leather")\nHAIR = "hair"\n')
        self.assertEqual([line.split(": ")[0] for line in structure.classes_written_out(self.root)],
                         ["dataset/a.cpp:1", "dataset/b.cpp:1", "blender_addon/c.py:1"])

    def test_a_long_function_and_a_long_list_of_parameters(self):
        self.write("bake/long.cpp", "void f(\n    int a) {\n" + "  ++a;\n" * 60 + "}\n")
        self.write("bake/wide.cpp", "void g(int a, int b, std::map<int, int> c, int d, int e, int f,\n       int h) {\n}\n")
        self.write("bake/file.h", "//\n" * 401)
        self.assertEqual(structure.too_long(self.root), ["bake/file.h: 401 lines", "bake/long.cpp:1: a function of 63 lines",
                                                         "bake/wide.cpp:1: a function of 7 parameters"])


if __name__ == "__main__":
    unittest.main(verbosity=2)
