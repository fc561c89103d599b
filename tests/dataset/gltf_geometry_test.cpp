// Where glTF's points lie: skins, morph targets, sparse, quantised and compressed data, far-away nodes.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "dataset/model/scan.h"
#include "tests/support/compressed_gltf.h"
#include "tests/support/paths.h"
#include "tests/support/test_files.h"

namespace ohb {
namespace {

Scan read(const GlbBuilder& glb) {
  const TemporaryFolder folder;
  return read_scan(write_bytes(folder / "a.glb", glb.bytes()));
}

std::string refusal(const GlbBuilder& glb) {
  return input_error_of([&] { read(glb); });
}

Vec3f corner(const Scan& scan, size_t index) {
  return scan.positions[scan.corners[index].position];
}

void expect_near(Vec3f found, Vec3f expected, float tolerance = 1e-6f) {
  EXPECT_NEAR(found.x, expected.x, tolerance);
  EXPECT_NEAR(found.y, expected.y, tolerance);
  EXPECT_NEAR(found.z, expected.z, tolerance);
}

bool has_note(const Scan& scan, const std::string& part) {
  for (const std::string& note : scan.notes)
    if (note.find(part) != std::string::npos) return true;
  return false;
}

TEST(GltfGeometry, SkinsTakeThePoseOfTheNodes) {
  const Scan scan = read(skinned_glb());
  expect_near(corner(scan, 0), {0, 0, 0});
  expect_near(corner(scan, 1), {1, 0, 0});
  // (1, 1, 0): the first joint turns it to (1, 0, 1), the second moves it to (1, 1, 2).
  expect_near(corner(scan, 2), {1, 0.5f, 1.5f});
  EXPECT_TRUE(has_note(scan, "pose of the file's nodes"));
}

/// As converted characters have it: centimetres and Z up in the joints, a joint below another, the root
/// turned and scaled, and the mesh's own node elsewhere.
GlbBuilder converted_rig() {
  GlbBuilder glb = skinned_glb();
  const double half = std::sqrt(0.5);
  glb.json["nodes"][0]["rotation"] = {half, 0, 0, half};
  glb.json["nodes"][1] = {
      {"name", "hips"}, {"translation", {0, 90, 5}}, {"rotation", {0, 0.6, 0, 0.8}}, {"children", {2}}};
  glb.json["nodes"][2] = {{"name", "spine"}, {"translation", {0, 20, 0}}, {"rotation", {0.28, 0, 0, 0.96}}};
  glb.json["nodes"].push_back({{"name", "Armature"},
                               {"scale", {0.01, 0.01, 0.01}},
                               {"rotation", {-half, 0, 0, half}},
                               {"children", {1, 0}}});
  glb.json["scenes"][0]["nodes"] = {3};
  std::vector<float> inverse(32, 0.0f);
  for (size_t k = 0; k < 2; ++k)
    for (size_t i = 0; i < 4; ++i) inverse[16 * k + 5 * i] = i < 3 ? 100.0f : 1.0f;
  inverse[13] = -80;  // translations
  inverse[29] = -100;
  glb.json["skins"][0]["inverseBindMatrices"] = glb.add(inverse, "MAT4", 5126);
  return glb;
}

TEST(GltfGeometry, PointsLieWhereBlenderPutsThem) {
  if (std::system("blender --version > /dev/null 2>&1") != 0) GTEST_SKIP() << "Blender is not there";
  GlbBuilder morphed;
  const size_t target = morphed.add<float>({0, 0, 1, 0, 0, 0, 0, 2, 0, 0, 0, 0}, "VEC3", 5126);
  morphed.json["accessors"][target]["min"] = {0, 0, 0};
  morphed.json["accessors"][target]["max"] = {0, 2, 1};
  morphed.primitive()["targets"] = {{{"POSITION", target}}};
  morphed.json["meshes"][0]["weights"] = {1.5};
  morphed.json["nodes"][0]["translation"] = {0, 1, 0};
  const std::vector<std::pair<std::string, GlbBuilder>> files{{"converted", converted_rig()},
                                                              {"morphed", morphed}};
  const TemporaryFolder folder;
  std::string command = "blender -b --factory-startup -noaudio -P " +
                        source_path("tests/dataset/blender_look.py") + " -- " + folder.path().string();
  for (const auto& [name, glb] : files)
    command += " " + write_bytes(folder / (name + ".glb"), glb.bytes()).string();
  ASSERT_EQ(std::system((command + " > /dev/null 2>&1").c_str()), 0);
  for (const auto& [name, glb] : files) {
    const Scan scan = read_scan(folder / (name + ".glb"));
    std::ifstream text(folder / (name + ".txt"));
    std::vector<Vec3f> shown;
    for (Vec3f p; text >> p.x >> p.y >> p.z;) shown.push_back(p);
    ASSERT_EQ(shown.size(), scan.positions.size()) << name;
    for (const Vec3f& p : scan.positions) {
      float nearest = INFINITY;
      for (const Vec3f& other : shown) nearest = std::min(nearest, length(other - p));
      EXPECT_LT(nearest, 2e-5f) << name << ": " << p.x << " " << p.y << " " << p.z;
    }
  }
}

TEST(GltfGeometry, BadSkinsAreNamed) {
  GlbBuilder glb = skinned_glb();
  glb.json["skins"][0]["joints"] = {1, 99};
  expect_message(refusal(glb), {"nodes[99]"});
  glb = skinned_glb();
  glb.json["skins"][0]["joints"] = {1};
  expect_message(refusal(glb), {"uses joint 1 of 1"});
  glb = skinned_glb();
  glb.json["skins"][0]["joints"] = {1, 2, 1};
  expect_message(refusal(glb), {"2 inverse bind matrices for 3 joints"});
  glb = skinned_glb();
  glb.json["nodes"][1]["children"] = {2};
  glb.json["nodes"][2]["children"] = {1};
  glb.json["scenes"][0]["nodes"] = {0};
  expect_message(refusal(glb), {"its own ancestor"});
}

TEST(GltfGeometry, MorphTargetsTakeTheirDefaultWeights) {
  GlbBuilder glb;
  const size_t target = glb.add<float>({0, 0, 1, 0, 0, 0, 0, 2, 0, 0, 0, 0}, "VEC3", 5126);
  glb.primitive()["targets"] = {{{"POSITION", target}}, {{"NORMAL", target}}};
  Scan scan = read(glb);
  expect_near(corner(scan, 0), {0, 0, 0});
  EXPECT_TRUE(has_note(scan, "default weights are 0"));
  glb.json["meshes"][0]["weights"] = {0.5, 1};
  scan = read(glb);
  expect_near(corner(scan, 0), {0, 0, 0.5f});
  expect_near(corner(scan, 2), {1, 2, 0});
  EXPECT_TRUE(has_note(scan, "applied at their default weights"));
  glb.json["nodes"][0]["weights"] = {-1, 0};  // a node's go first
  expect_near(corner(read(glb), 0), {0, 0, -1});
  glb.json["accessors"][target]["count"] = 3;
  expect_message(refusal(glb), {"3 moves of a morph target for 4 vertices"});
}

TEST(GltfGeometry, SparseElementsTakeThePlaceOfOthers) {
  GlbBuilder glb;
  const size_t places = glb.add<uint16_t>({1, 3}, "SCALAR", 5123);
  const size_t values = glb.add<float>({5, 6, 7, 8, 9, 10}, "VEC3", 5126);
  const auto view_of = [&](size_t accessor) { return glb.json["accessors"][accessor]["bufferView"]; };
  nlohmann::json& sparse = glb.json["accessors"][0]["sparse"];
  sparse = {{"count", 2},
            {"indices", {{"bufferView", view_of(places)}, {"componentType", 5123}}},
            {"values", {{"bufferView", view_of(values)}}}};
  Scan scan = read(glb);
  expect_near(corner(scan, 0), {0, 0, 0});
  expect_near(corner(scan, 1), {5, 6, 7});
  expect_near(corner(scan, 5), {8, 9, 10});
  glb.json["accessors"][0].erase("bufferView");  // zeros elsewhere
  expect_near(corner(read(glb), 2), {0, 0, 0});
  sparse["indices"]["byteOffset"] = 2;
  expect_message(refusal(glb), {"accessors[0].sparse", "goes beyond"});
  sparse["count"] = 5;
  expect_message(refusal(glb), {"other elements than its accessor"});
}

TEST(GltfGeometry, QuantisedNumbersBecomeFractions) {
  GlbBuilder glb;
  glb.json["extensionsRequired"] = {"KHR_mesh_quantization"};
  glb.primitive()["attributes"]["POSITION"] =
      glb.add<int16_t>({0, 0, 0, 32767, 0, 0, 32767, -32767, 0, 0, 32767, 0}, "VEC3", 5122, true);
  glb.json["nodes"][0]["scale"] = {2, 2, 2};
  const Scan scan = read(glb);
  expect_near(corner(scan, 1), {2, 0, 0});
  expect_near(corner(scan, 2), {2, -2, 0});
}

TEST(GltfGeometry, FarAwayNodesKeepTheirDetail) {
  GlbBuilder glb;
  glb.json["nodes"][0]["translation"] = {456789.25, 120.0, 5432100.5};
  const Scan scan = read(glb);
  ASSERT_TRUE(scan.removed_offset);
  EXPECT_NEAR(corner(scan, 1).x - corner(scan, 0).x, 1, 1e-6);
  EXPECT_NEAR(corner(scan, 0).z + scan.removed_offset->z, 5432100.5, 1e-6);
}

TEST(GltfGeometry, MeshoptDataIsDecoded) {
  const Scan scan = read(meshopt_glb()), plain = read(GlbBuilder());
  ASSERT_EQ(scan.face_count(), 2u);
  for (size_t c = 0; c < 6; ++c) expect_near(corner(scan, c), corner(plain, c));
}

TEST(GltfGeometry, WhatIsNotCompressedStandsInForDamagedMeshoptData) {
  GlbBuilder glb = meshopt_glb();
  nlohmann::json& view = glb.json["bufferViews"][0];
  view["extensions"]["EXT_meshopt_compression"]["byteLength"] = 3;
  view["buffer"] = 0;  // where the plain positions still are
  const Scan scan = read(glb), plain = read(GlbBuilder());
  for (size_t c = 0; c < 6; ++c) expect_near(corner(scan, c), corner(plain, c));
}

TEST(GltfGeometry, DamagedMeshoptDataIsNamed) {
  GlbBuilder glb = meshopt_glb();
  nlohmann::json& compression = glb.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"];
  compression["byteLength"] = 3;
  expect_message(refusal(glb), {"bufferViews[0]", "EXT_meshopt_compression", "cannot be decoded"});
  compression["byteStride"] = 7;
  expect_message(refusal(glb), {"4 elements of 7 bytes"});
  compression["byteStride"] = 12;
  compression["count"] = 60000000;
  expect_message(refusal(glb), {"too short"});
  glb = meshopt_glb();
  glb.json["bufferViews"][0].erase("extensions");
  expect_message(refusal(glb), {"not compressed"});
}

TEST(GltfGeometry, DracoDataIsDecodedInItsOwnOrder) {
  GlbBuilder glb = draco_glb();
  const Scan scan = read(glb), plain = read(GlbBuilder());
  ASSERT_EQ(scan.face_count(), 2u);
  for (size_t c = 0; c < 6; ++c) expect_near(corner(scan, c), corner(plain, c));
  glb.json["bufferViews"].back()["byteLength"] = 30;
  expect_message(refusal(glb), {"KHR_draco_mesh_compression", "cannot be decoded"});
}

TEST(GltfGeometry, WhatIsRequiredAndNotReadIsNamedFirst) {
  GlbBuilder glb;
  glb.json["extensionsRequired"] = {"KHR_texture_basisu"};
  glb.json["buffers"] = {{{"byteLength", 10000}}};  // truncated besides
  std::string bytes = glb.bytes();
  expect_message(refusal(glb), {"needs KHR_texture_basisu", "PNG or JPEG"});
}

}  // namespace
}  // namespace ohb
