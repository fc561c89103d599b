// Kinds of OBJ files that users bring and that went wrong: each has its right value here. At the end the
// small files of the shared data, OBJ and FBX.
#include "dataset/model/colour.h"
#include "dataset/model/scan.h"
#include "tests/support/scan_files.h"
#include "tests/support/shared_data.h"
#include "tests/support/test_files.h"

namespace ohb {
namespace {

namespace fs = std::filesystem;

bool is_noted(const Scan& scan, const std::string& part) {
  for (const std::string& note : scan.notes)
    if (note.find(part) != std::string::npos) return true;
  return false;
}

/// The square of kQuadObj with these lines in its .mtl's only material; "p.png" is there.
Scan scan_of_mtl(const TemporaryFolder& folder, const std::string& lines) {
  write_small_png(folder / "p.png", 4);
  write_bytes(folder / "m.mtl", "newmtl a\n" + lines);
  return read_scan(write_bytes(folder / "scan.obj", "mtllib m.mtl\nusemtl a\n" + std::string(kQuadObj)));
}

Scan scan_of_obj(const TemporaryFolder& folder, const std::string& text) {
  return read_scan(write_bytes(folder / "scan.obj", text));
}

TEST(FaultsObj, CoordinatesOfMapsKeepTheirDetail) {
  const TemporaryFolder folder;
  const Scan scan =
      scan_of_obj(folder,
                  "v 487213.001 102.5 5428812.9\nv 487213.501 102.5 5428812.9\n"
                  "v 487213.501 104.2 5428812.903\nv 487213.001 104.2 5428812.903\nf 1 2 3 4\n");
  ASSERT_TRUE(scan.removed_offset);
  EXPECT_NEAR(scan.positions[1].x - scan.positions[0].x, 0.5, 1e-6);
  EXPECT_NEAR(scan.positions[2].z - scan.positions[1].z, 0.003, 1e-6);
  EXPECT_NEAR(scan.positions[2].z + scan.removed_offset->z, 5428812.903, 1e-6);
  EXPECT_TRUE(is_noted(scan, "far from the origin"));
}

TEST(FaultsObj, DamageOfSinglePrecisionInTheFileIsTold) {
  const auto square = [](const char* format, double width) {
    std::string text;
    for (const auto& [right, up] : {std::pair(0.0, 0.0), {width, 0.0}, {width, 1.7}, {0.0, 1.7}}) {
      char line[100];
      std::snprintf(line, sizeof line, format, 487213.013 + right, 102.5 + up, 5428812.9 + 0.013 * up);
      text += line;
    }
    return text + "f 1 2 3 4\n";
  };
  const TemporaryFolder folder;
  EXPECT_FALSE(is_noted(scan_of_obj(folder, square("v %.3f %.3f %.3f\n", .507)), "single precision"));
  // 487213.013 and 5428812.9 as float, written with six digits after the point.
  EXPECT_TRUE(is_noted(scan_of_obj(folder,
                                   "v 487213.000000 102.5 5428813.000000\nv 487213.531250 102.5 5428813.0\n"
                                   "v 487213.531250 104.2 5428812.500000\nf 1 2 3\n"),
                       "in steps of 0.5, as single precision"));
  EXPECT_FALSE(is_noted(scan_of_obj(folder, kQuadObj), "single precision"));
}

TEST(FaultsObj, OpacityOfMtl) {
  for (const auto& [lines, opacity] : std::vector<std::pair<std::string, float>>{{"", 1},
                                                                                 {"d .05\n", .05f},
                                                                                 {"d -halo 0.25\n", .25f},
                                                                                 {"Tr .75\n", .25f},
                                                                                 {"Tr 1\nd 1\n", 1},
                                                                                 {"d 1\nTr 1\n", 1},
                                                                                 {"d 7\n", 1},
                                                                                 {"map_d p.png\nd .5\n", .5f},
                                                                                 {"map_d p.png\nd 0\n", 1}}) {
    const TemporaryFolder folder;
    const Scan scan = scan_of_mtl(folder, lines);
    EXPECT_FLOAT_EQ(scan.materials[0].opacity, opacity) << lines;
    EXPECT_EQ(is_noted(scan, "opacity"), opacity < 1) << lines;
  }
  const TemporaryFolder folder;
  EXPECT_TRUE(is_noted(scan_of_mtl(folder, "d 0\n"), "it is not seen"));
  const Scan doubtful = scan_of_mtl(folder, "Tr 1\n");
  EXPECT_EQ(doubtful.materials[0].opacity, 1);
  EXPECT_TRUE(is_noted(doubtful, "Tr 1 is taken as opaque"));
  expect_message(input_error_of([&] { scan_of_mtl(folder, "d much\n"); }), {"m.mtl: line 2", "'much'"});
}

TEST(FaultsObj, PicturesAreMovedAndClamped) {
  const TemporaryFolder folder;
  const Scan moved = scan_of_mtl(folder, "map_Kd -s 2 3 1 -o .25 .5 0 p.png\n");
  EXPECT_FLOAT_EQ(moved.uvs[0].x, .25f);
  EXPECT_FLOAT_EQ(moved.uvs[0].y, .5f);
  EXPECT_FLOAT_EQ(moved.uvs[2].x, 2.25f);
  EXPECT_FLOAT_EQ(moved.uvs[2].y, 3.5f);
  const Scan same = scan_of_mtl(folder, "map_Kd -s 1 1 1 -o 0 0 -t 0 0 0 -clamp off p.png\n");
  EXPECT_TRUE(same.materials[0].diffuse.view.is_plain());
  EXPECT_FALSE(scan_of_mtl(folder, "map_Kd -clamp on -s 2 2 p.png\n").materials[0].diffuse.view.is_plain());
}

TEST(FaultsObj, ColoursAtTheVertices) {
  const TemporaryFolder folder;
  const std::string vertices = "v 0 0 0 1 0 0.5\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\nv 0 1 0\n";
  const Scan scan = scan_of_obj(folder, vertices + "f 1 2 3\nf 1 3 4\n");
  ASSERT_EQ(scan.corner_colours.size(), 6u);
  EXPECT_FLOAT_EQ(scan.corner_colours[0].rgb.x, 1);
  EXPECT_FLOAT_EQ(scan.corner_colours[0].rgb.z, srgb_to_linear(.5f));
  EXPECT_FLOAT_EQ(scan.corner_colours[3].rgb.y, 1) << "a vertex without colour leaves its faces without";
  EXPECT_TRUE(scan.materials[0].has_vertex_colours);
  EXPECT_TRUE(is_noted(scan, "the colours at its vertices are taken"));

  const Scan bytes = scan_of_obj(folder, "v 0 0 0 255 0 0\nv 1 0 0 0 51 0\nv 1 1 0 0 0 255\nf 1 2 3\n");
  EXPECT_FLOAT_EQ(bytes.corner_colours[1].rgb.y, srgb_to_linear(.2f));
  const Scan weights = scan_of_obj(folder, "v 0 0 0 1\nv 1 0 0 1\nv 1 1 0 1\nf 1 2 3\n");
  EXPECT_TRUE(weights.corner_colours.empty());
  const Scan brush =
      scan_of_obj(folder, "v 0 0 0\nv 1 0 0\nv 1 1 0\n#MRGB ffff0000ff00ff00ff0000ff\nf 1 2 3\n");
  EXPECT_FLOAT_EQ(brush.corner_colours[1].rgb.y, 1);
  EXPECT_FLOAT_EQ(brush.corner_colours[1].rgb.x, 0);

  write_small_png(folder / "p.png");
  write_bytes(folder / "m.mtl", "newmtl a\nmap_Kd p.png\n");
  const Scan with_picture = scan_of_obj(folder, "mtllib m.mtl\nusemtl a\n" + vertices + "f 1 2 3\n");
  EXPECT_TRUE(with_picture.corner_colours.empty());
  EXPECT_TRUE(is_noted(with_picture, "colours at its vertices are not used"));
}

TEST(FaultsShared, RowsOfTheTable) {
  OHB_SHARED_DATA_OR_SKIP(faults, "faults");
  const Scan map = read_scan(faults / "05-georeferenced-float32/georef/a.obj");
  EXPECT_NEAR(map.positions[5].z - map.positions[1].z, -.3, 1e-6);
  EXPECT_FLOAT_EQ(read_scan(faults / "12-clear-shell-opaque/obj_d/a.obj").materials.back().opacity, .05f);
  EXPECT_EQ(read_scan(faults / "14-fbx6-ascii-called-damaged/a.fbx").positions.size(), 4u);
  const Scan scaled = read_scan(faults / "17-fbx-texture-scale-ignored/tex_scaling/a.fbx");
  EXPECT_FLOAT_EQ(scaled.uvs[2].x, 1);  // .5 in the file
  for (const char* name : {"case_tex", "quoted_tex", "umlaut_latin1", "winabs"})
    EXPECT_FALSE(read_scan(faults / "08-obj-foreign-paths" / name / "a.obj").materials.at(0).diffuse.empty());
}

}  // namespace
}  // namespace ohb
