#include "dataset/model/scan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <random>

#include "dataset/model/atomic_file.h"
#include "tests/support/fbx_files.h"
#include "tests/support/paths.h"
#include "tests/support/scan_files.h"
#include "tests/support/shared_data.h"
#include "tests/support/test_files.h"

namespace ohb {
namespace {

Scan read_obj_text(const std::string& text) {
  const TemporaryFolder folder;
  return read_scan(write_bytes(folder / "scan.obj", text));
}

double area_of(const Scan& scan, const ScanTriangle& t) {
  const auto p = [&](int i) { return scan.positions[scan.corners[t.corner[i]].position]; };
  return 0.5 * length(cross(p(1) - p(0), p(2) - p(0)));
}

TEST(ScanObj, KeepsFaceAndCornerOrder) {
  const Scan scan = read_obj_text(
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nvt .5 .25\n"
      "g one\nusemtl red\nf 3 2 5\ng two\nusemtl blue\nf 4/1 1/1 2/1 3/1\ng one\nusemtl red\nf -5 -4 -3\n");
  ASSERT_EQ(scan.face_count(), 3u);
  EXPECT_EQ(scan.face_begin, (std::vector<uint32_t>{0, 3, 7, 10}));
  std::vector<uint32_t> positions;
  for (const Corner& corner : scan.corners) positions.push_back(corner.position);
  EXPECT_EQ(positions, (std::vector<uint32_t>{2, 1, 4, 3, 0, 1, 2, 0, 1, 2}));
  EXPECT_EQ(scan.corners[0].uv, Corner::kNoUv);
  EXPECT_EQ(scan.corners[3].uv, 0u);
  EXPECT_EQ(scan.groups, (std::vector<std::string>{"one", "two"}));
  EXPECT_EQ(scan.face_group, (std::vector<uint16_t>{0, 1, 0}));
  ASSERT_EQ(scan.materials.size(), 2u);
  EXPECT_EQ(scan.materials[1].name, "blue");
  EXPECT_EQ(scan.face_material, (std::vector<uint16_t>{0, 1, 0}));
  EXPECT_FALSE(scan.stated_unit_cm.has_value());
}

TEST(ScanObj, PositionsAreTheNearestFloats) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> value(-200, 200);
  std::string text;
  std::vector<float> expected;
  for (int i = 0; i < 3000; ++i) {
    char number[64];
    std::snprintf(number, sizeof number, i % 3 ? "%.17g" : "%.9e", value(random));
    expected.push_back(std::strtof(number, nullptr));
    text += (i % 3 == 0 ? "v " : " ") + std::string(number) + (i % 3 == 2 ? "\n" : "");
  }
  const Scan scan = read_obj_text(text + "f 1 2 3\n");
  for (size_t i = 0; i < expected.size(); ++i)
    ASSERT_EQ(scan.positions[i / 3][static_cast<int>(i % 3)], expected[i]);
}

TEST(ScanObj, AcceptsTheDialectsOfExporters) {
  const char* variants[] = {
      "\xEF\xBB\xBFv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",              // byte-order mark
      "v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2 3\r\n",                  // CR LF
      "v 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3",                            // CR, no end of line
      "# head\n\n\tv  0 0 0 # x\nv 1 0 0\nv 0 1 0\n  f 1 2 \\\n 3\n",  // blanks, comments, joined lines
      "v 0 0 0 1 1 1\nv 1 0 0 .5 .5 .5\nv 0 1 0 0 0 0\nf 1 2 3\n",     // vertex colours
      "f 1 2 3\nv +0 0 0\nv 1e0 0 0\nv 0 1. 0\nl 1 2\np 1\ns off\n",   // faces first, lines and points
      "v 0 0 0\nv 1 0 0\nv 0 1 1e-60\nf 1// 2// 3//\n",                // underflow, empty indices
  };
  for (const char* text : variants) {
    const Scan scan = read_obj_text(text);
    EXPECT_EQ(scan.face_count(), 1u) << text;
    EXPECT_EQ(scan.positions.size(), 3u) << text;
    EXPECT_EQ(scan.positions[1].x, 1.0f) << text;
  }
}

TEST(ScanObj, MaterialsAndTheirPictures) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "my textures");
  write_small_png(folder / "my textures/skin map.png");
  write_small_png(folder / "hair.png", 4);
  Image flat(4, 4, 3);
  for (size_t i = 0; i < flat.values.size(); ++i) flat.values[i] = i % 3 == 2 ? 1.0f : 0.5f;
  write_png(folder / "n.png", flat);
  write_png(folder / "height.png", Image(4, 4, 1));
  write_bytes(folder / "a b.mtl",
              "newmtl skin\r\nKd .1 .2 .3\r\nmap_Kd -clamp on -s 1 1 1 my textures\\skin map.png\r\n"
              "map_Bump -bm 1.0 n.png\r\nnewmtl hair\nKd .25 .5 1\nmap_d -imfchan m hair.png\nnorm n.png\n"
              "bump height.png\n");
  const Scan scan =
      read_scan(write_bytes(folder / "scan.obj", std::string("mtllib a b.mtl\n") + kQuadObj +
                                                     "usemtl hair\nf 1 2 3\nusemtl skin\nf 1 2 3\n"));
  ASSERT_EQ(scan.materials.size(), 3u);
  EXPECT_EQ(scan.materials[0].name, "default");
  const ScanMaterial &hair = scan.materials[1], &skin = scan.materials[2];
  EXPECT_EQ(hair.alpha.file, folder / "hair.png");
  EXPECT_TRUE(hair.diffuse.empty());
  EXPECT_EQ(hair.diffuse_factor.y, 0.5f);
  EXPECT_EQ(hair.normal.file, folder / "n.png");
  EXPECT_EQ(skin.diffuse.file, folder / "my textures/skin map.png");
  EXPECT_EQ(skin.diffuse_factor.y, 1.0f) << "Kd does not tint a picture";
  EXPECT_EQ(skin.normal.file, folder / "n.png");
  ASSERT_EQ(scan.notes.size(), 1u);
  EXPECT_NE(scan.notes[0].find("height.png"), std::string::npos);
}

TEST(ScanTriangulate, QuadsSplitAlongTheShorterDiagonal) {
  const char* corners[] = {"v 0 0 0\nv 1 0 0\nv 3 1 0\nv 0 1 0\n", "v 0 0 0\nv 3 0 0\nv 1 1 0\nv 0 1 0\n"};
  for (int i = 0; i < 2; ++i) {
    const Scan scan = read_obj_text(std::string(corners[i]) + "f 1 2 3 4\n");
    const auto triangles = triangulate(scan);
    ASSERT_EQ(triangles.size(), 2u);
    const auto p = [&](int k) { return scan.positions[static_cast<size_t>(k)]; };
    const bool second = length(p(3) - p(1)) < length(p(2) - p(0));
    EXPECT_EQ(second, i == 0);
    EXPECT_EQ(triangles[0].corner[2], second ? 3u : 2u);
  }
  // A dart: the shorter diagonal 2-4 would leave it.
  const Scan dart = read_obj_text("v 0 0 0\nv 4 -1 0\nv 1 0 0\nv 4 1 0\nf 1 2 3 4\n");
  for (const ScanTriangle& t : triangulate(dart)) {
    const auto p = [&](int k) { return dart.positions[dart.corners[t.corner[k]].position]; };
    EXPECT_GT(cross(p(1) - p(0), p(2) - p(0)).z, 0);
  }
}

TEST(ScanTriangulate, AreasOfStarsEqualTheShoelaceFormula) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> radius(0.3, 1);
  for (int corners = 5; corners < 60; corners += 3) {
    std::string text, face = "f";
    double expected = 0;
    std::vector<double> x, y;
    for (int i = 0; i < corners; ++i) {
      const double a = 2 * M_PI * i / corners, r = radius(random);
      x.push_back(static_cast<float>(r * std::cos(a)));
      y.push_back(static_cast<float>(r * std::sin(a)));
      char line[128];
      // In the plane z = 2 x, so that the projection is tested too.
      std::snprintf(line, sizeof line, "v %.9g %.9g %.9g\n", x.back(), y.back(), 2 * x.back());
      text += line;
      face += " " + std::to_string(i + 1);
    }
    for (size_t i = 0, n = x.size(); i < n; ++i)
      expected += 0.5 * (x[i] * y[(i + 1) % n] - x[(i + 1) % n] * y[i]);
    const Scan scan = read_obj_text(text + face + "\n");
    const auto triangles = triangulate(scan);
    EXPECT_EQ(triangles.size(), static_cast<size_t>(corners - 2));
    double sum = 0;
    for (const ScanTriangle& t : triangles) sum += area_of(scan, t);
    EXPECT_NEAR(sum, expected * std::sqrt(5.0), 1e-5) << corners;
  }
}

TEST(ScanGltf, QuadWithEmbeddedPicture) {
  const TemporaryFolder folder;
  write_small_png(folder / "p.png", 4);
  const std::string png = read_file(folder / "p.png");
  const Scan scan =
      read_scan(write_bytes(folder / "scan.glb", glb_of(quad_glb_json(png.size()), quad_glb_binary(png))));
  EXPECT_EQ(scan.face_count(), 2u);
  EXPECT_EQ(scan.positions.size(), 4u);
  EXPECT_EQ(scan.groups, std::vector<std::string>{"square"});
  EXPECT_EQ(scan.stated_unit_cm, 100.0);
  const Scan obj = read_obj_text(kQuadObj);
  for (size_t c = 0; c < 3; ++c) {
    const Vec2f uv = scan.uvs[scan.corners[c].uv], expected = obj.uvs[obj.corners[c].uv];
    EXPECT_EQ(uv.x, expected.x);
    EXPECT_EQ(uv.y, expected.y) << "v is up";
  }
  ASSERT_EQ(scan.materials.size(), 1u);
  EXPECT_EQ(scan.materials[0].name, "cloth");
  ImageFileInfo info;
  const Image embedded = read_image(scan.materials[0].diffuse, &info), file = read_image(folder / "p.png");
  EXPECT_EQ(embedded.values, file.values);
  EXPECT_TRUE(info.has_alpha);
  EXPECT_EQ(info.bits, 8);
  EXPECT_EQ(scan.materials[0].alpha.embedded, scan.materials[0].diffuse.embedded);
  size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) files += entry.exists();
  EXPECT_EQ(files, 2u) << "reading must not write";
}

TEST(ScanGltf, WeldsWhatUvSeamsSplit) {
  std::string binary;
  const float minus_zero = -0.0f;
  append<float>(binary, {0, 0, 0, 1, 0, 0, 1, 1, 0, minus_zero, 0, 0, 1, 1, 0, 0, 1, 0});
  const std::string json =
      R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0,"scale":[-2,2,2],"translation":[5,0,0]}],)"
      R"("meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],)"
      R"("accessors":[{"bufferView":0,"componentType":5126,"count":6,"type":"VEC3"}],)"
      R"("bufferViews":[{"buffer":0,"byteLength":72}],"buffers":[{"byteLength":72}]})";
  const TemporaryFolder folder;
  const Scan scan = read_scan(write_bytes(folder / "scan.glb", glb_of(json, binary)));
  EXPECT_EQ(scan.face_count(), 2u);
  EXPECT_EQ(scan.positions.size(), 4u);
  EXPECT_EQ(scan.positions[scan.corners[0].position].x, 5.0f);
  for (const ScanTriangle& t : triangulate(scan)) {
    const auto p = [&](int k) { return scan.positions[scan.corners[t.corner[k]].position]; };
    EXPECT_GT(cross(p(1) - p(0), p(2) - p(0)).z, 0) << "a mirrored node keeps its front";
  }
}

/// A wavy sheet of n x n quads in two materials, whose UVs are split along the middle.
std::string sheet_obj(int n) {
  std::string text = "mtllib m.mtl\n";
  char line[160];
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      std::snprintf(line, sizeof line, "v %.6g %.6g %.6g\nvt %.6g %.6g\nvt %.6g %.6g\n", 0.1 * i,
                    0.1 * j + 0.01 * (i % 3), 0.03 * ((i * 7 + j * 5) % 11), 0.4 * i / n, 0.8 * j / n,
                    0.5 + 0.4 * i / n, 0.8 * j / n);
      text += line;
    }
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i + 1, c = a + n + 2, shift = i < n / 2 ? 1 : 0;
      std::snprintf(line, sizeof line, "usemtl %s\nf %d/%d %d/%d %d/%d %d/%d\n", (i + j) % 3 ? "red" : "blue",
                    a, 2 * a - shift, a + 1, 2 * (a + 1) - shift, c, 2 * c - shift, c - 1,
                    2 * (c - 1) - shift);
      text += line;
    }
  return text;
}

/// Corners in face order as (x, y, z, u, v) in cm.
std::vector<std::array<double, 5>> corners_of(const Scan& scan, double unit_cm) {
  std::vector<std::array<double, 5>> all;
  for (const Corner& corner : scan.corners) {
    const Vec3f p = scan.positions[corner.position];
    const Vec2f uv = scan.uvs[corner.uv];
    all.push_back({unit_cm * p.x, unit_cm * p.y, unit_cm * p.z, uv.x, uv.y});
  }
  return all;
}

TEST(ScanFiles, BlendersGlbAndFbxOfAnObjAreTheSameScan) {
  if (std::system("blender --version > /dev/null 2>&1") != 0) GTEST_SKIP() << "Blender is not there";
  const TemporaryFolder folder;
  write_small_png(folder / "p.png");
  write_bytes(folder / "m.mtl", "newmtl red\nmap_Kd p.png\nnewmtl blue\nmap_Kd p.png\n");
  const int n = 12;
  write_bytes(folder / "sheet.obj", sheet_obj(n));
  const std::string command = "blender -b --factory-startup -noaudio -P " +
                              source_path("tests/dataset/convert_scan.py") + " -- " +
                              (folder / "sheet.obj").string() + " " + (folder / "sheet.glb").string() + " " +
                              (folder / "sheet.fbx").string() + " > /dev/null 2>&1";
  ASSERT_EQ(std::system(command.c_str()), 0);
  const Scan obj = read_scan(folder / "sheet.obj"), glb = read_scan(folder / "sheet.glb"),
             fbx = read_scan(folder / "sheet.fbx");
  // Blender took the OBJ's units for metres; its FBX states centimetres and scales the node by 100.
  const auto expected = corners_of(obj, 100), polygons = corners_of(fbx, *fbx.stated_unit_cm);
  ASSERT_EQ(polygons.size(), expected.size());
  for (size_t c = 0; c < expected.size(); ++c)
    for (size_t k = 0; k < 5; ++k) ASSERT_NEAR(polygons[c][k], expected[c][k], 1e-4) << "corner " << c;
  for (size_t f = 0; f < obj.face_count(); ++f)
    ASSERT_EQ(fbx.materials[fbx.face_material[f]].name, obj.materials[obj.face_material[f]].name);
  EXPECT_EQ(fbx.positions.size(), obj.positions.size());
  EXPECT_EQ(glb.positions.size(), obj.positions.size())
      << "split at UV seams and materials, and welded again";
  EXPECT_EQ(glb.face_count(), 2 * obj.face_count());
  // GLB sorts faces by material; every corner of ours is one of its corners.
  auto triangles = corners_of(glb, *glb.stated_unit_cm);
  for (const auto& corner : expected) {
    const bool found = std::any_of(triangles.begin(), triangles.end(), [&](const auto& other) {
      double farthest = 0;
      for (size_t k = 0; k < 5; ++k) farthest = std::max(farthest, std::abs(other[k] - corner[k]));
      return farthest < 1e-3;
    });
    ASSERT_TRUE(found);
  }
  for (const Scan* scan : {&glb, &fbx})
    for (const ScanMaterial& material : scan->materials)
      EXPECT_EQ(read_image(material.diffuse).values, read_image(folder / "p.png").values);
}

TEST(ScanFbx, BinaryAndAsciiAgree) {
  const TemporaryFolder folder;
  for (const std::string& bytes : {quad_fbx(), ascii_quad_fbx()}) {
    const Scan scan = read_scan(write_bytes(folder / "scan.fbx", bytes));
    ASSERT_EQ(scan.face_count(), 1u);
    EXPECT_EQ(scan.stated_unit_cm, 100.0);
    EXPECT_EQ(scan.groups, std::vector<std::string>{"body"});
    EXPECT_EQ(scan.materials.at(scan.face_material[0]).name, "cloth");
    ASSERT_EQ(scan.corners.size(), 4u);
    const Vec3f p = scan.positions[scan.corners[2].position];
    EXPECT_EQ(p.x, 2.0f);
    EXPECT_EQ(p.y, 2.0f);
    EXPECT_EQ(scan.uvs[scan.corners[3].uv].y, 1.0f);
  }
}

TEST(ScanFbx, ZUpIsTurnedAndMirroredFacesKeepTheirFront) {
  std::string text = ascii_quad_fbx();
  text.replace(text.find("\t\tP: \"UnitScale"), 0,
               "\t\tP: \"UpAxis\", \"int\", \"Integer\", \"\",2\n\t\tP: \"CoordAxis\", \"int\", \"Integer\", "
               "\"\",0\n");
  text.replace(text.find("\"A\",2,2,2"), 9, "\"A\",2,2,-2");
  const TemporaryFolder folder;
  const Scan scan = read_scan(write_bytes(folder / "scan.fbx", text));
  const Vec3f p = scan.positions[2];  // (1, 1, 0), Z up
  EXPECT_EQ(p.x, 2.0f);
  EXPECT_EQ(p.y, 0.0f);
  EXPECT_EQ(p.z, -2.0f);
  EXPECT_EQ(scan.corners[0].position, 0u);
  EXPECT_EQ(scan.corners[1].position, 3u);
}

TEST(ScanFiles, EveryHumanLoadsWithTheCountsOfItsFile) {
  OHB_SHARED_DATA_OR_SKIP(humans, "humans");
  for (const std::filesystem::path& file : objs_below(humans)) {
    SCOPED_TRACE(file.string());
    const Scan scan = read_scan(file);
    size_t faces = 0, vertices = 0;
    std::ifstream text(file);
    for (std::string line; std::getline(text, line);) {
      faces += line.compare(0, 2, "f ") == 0;
      vertices += line.compare(0, 2, "v ") == 0;
    }
    EXPECT_EQ(scan.face_count(), faces);
    EXPECT_EQ(scan.positions.size(), vertices);
    EXPECT_EQ(scan.corners.size(), triangulate(scan).size() + 2 * faces);
    for (const ScanMaterial& material : scan.materials) EXPECT_FALSE(material.diffuse.empty());
  }
}

}  // namespace
}  // namespace ohb
