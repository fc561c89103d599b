// Exact copies of faces are found and left out; near copies and layers of strands are not.
#include "bake/repeated_faces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <tuple>

#include "bake/bake.h"
#include "tests/bake/test_scans.h"

namespace ohb {
using namespace bake;
using namespace surface;
namespace {

constexpr MaterialTable kTable = {
    {{0.184f, 0.4f, 0.08f}, {0.239f, 0.5f, 0}, {0.263f, 0.85f, 0}, {0.224f, 0.25f, 0}}};

/// A scan of no faces yet, with an opaque material and one with a cut-out.
Scan empty_scan() {
  Scan scan;
  scan.file = "copies.obj";
  scan.groups = {"all"};
  scan.face_begin = {0};
  scan.materials.resize(2);
  scan.materials[0].name = "solid";
  scan.materials[1].name = "strands";
  scan.materials[1].alpha.file = "strands.png";
  return scan;
}

struct Place {
  Vec3f position;
  Vec2f uv;
};

/// Each face with vertices of its own.
void add_face(Scan& scan, uint16_t material, const std::vector<Place>& places) {
  for (const Place& place : places) {
    scan.corners.push_back(
        {static_cast<uint32_t>(scan.positions.size()), static_cast<uint32_t>(scan.uvs.size())});
    scan.positions.push_back(place.position);
    scan.uvs.push_back(place.uv);
  }
  scan.face_begin.push_back(static_cast<uint32_t>(scan.corners.size()));
  scan.face_material.push_back(material);
  scan.face_group.push_back(0);
}

const std::vector<Place> kQuad = {
    {{0, 0, 0}, {0, 0}}, {{1, 0, 0}, {1, 0}}, {{1, 1, 0}, {1, 1}}, {{0, 1, 0}, {0, 1}}};

std::vector<Place> turned(std::vector<Place> places, int by) {
  std::rotate(places.begin(), places.begin() + by, places.end());
  return places;
}
std::vector<Place> reversed(std::vector<Place> places) {
  std::reverse(places.begin(), places.end());
  return places;
}
std::vector<Place> moved(std::vector<Place> places, Vec3f by, Vec2f uv_by = {0, 0}) {
  for (Place& place : places) place.position += by, place.uv = place.uv + uv_by;
  return places;
}

TEST(RepeatedFaces, CopiesAreFoundHoweverTheyAreWritten) {
  Scan scan = empty_scan();
  add_face(scan, 0, kQuad);
  add_face(scan, 0, turned(kQuad, 1));
  add_face(scan, 0, reversed(kQuad));
  add_face(scan, 0, moved(kQuad, {0, 0, 0}, {0.5f, 0}));  // opaque: whatever picture hides behind the first
  add_face(scan, 0, moved(kQuad, {-0.0f, -0.0f, -0.0f}));
  EXPECT_EQ(repeated_faces(scan), (std::vector<bool>{false, true, true, true, true}));
}

TEST(RepeatedFaces, NearCopiesAndPartsAreNone) {
  Scan scan = empty_scan();
  add_face(scan, 0, kQuad);
  add_face(scan, 0, moved(kQuad, {0, 0, std::nextafter(0.0f, 1.0f)}));
  add_face(scan, 0, {kQuad[0], kQuad[1], kQuad[2]});
  add_face(scan, 0, {kQuad[0], kQuad[1], kQuad[1], kQuad[2]});
  add_face(scan, 1, kQuad);  // cloth where skin is
  EXPECT_EQ(repeated_faces(scan), std::vector<bool>(5, false));
}

TEST(RepeatedFaces, LayersOfStrandsStay) {
  Scan scan = empty_scan();
  add_face(scan, 1, kQuad);
  add_face(scan, 1, moved(kQuad, {0, 0, 0}, {0.5f, 0}));
  add_face(scan, 1, turned(kQuad, 2));
  EXPECT_EQ(repeated_faces(scan), (std::vector<bool>{false, false, true}));
}

TEST(RepeatedFaces, AgreeWithComparingAllPairs) {
  std::mt19937 random(5);
  std::uniform_int_distribution<int> coordinate(0, 1), corners(3, 4), material(0, 1);
  Scan scan = empty_scan();
  std::vector<std::vector<Place>> faces;
  for (int f = 0; f < 400; ++f) {
    std::vector<Place> places;
    const int count = corners(random);
    const auto bit = [&] { return static_cast<float>(coordinate(random)); };
    for (int c = 0; c < count; ++c) {
      const Vec3f position{bit(), bit(), bit()};
      places.push_back({position, {bit(), 0}});
    }
    add_face(scan, static_cast<uint16_t>(material(random)), places);
    faces.push_back(places);
  }
  const auto key = [&](size_t f) {
    std::vector<std::tuple<float, float, float, float, float>> places;
    for (const Place& p : faces[f]) {
      const Vec2f uv = scan.face_material[f] == 1 ? p.uv : Vec2f{0, 0};
      places.emplace_back(p.position.x, p.position.y, p.position.z, uv.x, uv.y);
    }
    std::sort(places.begin(), places.end());
    return std::make_pair(scan.face_material[f], places);
  };
  const std::vector<bool> repeated = repeated_faces(scan);
  size_t copies = 0;
  for (size_t f = 0; f < faces.size(); ++f) {
    bool expected = false;
    for (size_t g = 0; g < f; ++g) expected |= key(f) == key(g);
    EXPECT_EQ(repeated[f], expected) << f;
    copies += expected;
  }
  EXPECT_GT(copies, 50u);
  EXPECT_LT(copies, 350u);
}

TEST(RepeatedFaces, BakeLeavesThemOutAndSaysSo) {
  Scan scan = empty_scan();
  scan.materials.resize(1);
  add_face(scan, 0, kQuad);
  add_face(scan, 0, reversed(kQuad));
  add_face(scan, 0, moved(kQuad, {2, 0, 0}, {2, 0}));
  BakeOptions options;
  options.size_px = 16;
  options.quiet = true;
  BakeReport report;
  const Model model = bake_model(scan, one_class(scan), kTable, options, &report);
  ASSERT_EQ(model.triangles.size(), 4u);
  EXPECT_EQ(model.positions_cm.size(), 8u);
  EXPECT_EQ(model.triangles[1].source_face, 0u);
  EXPECT_EQ(model.triangles[2].source_face, 2u);
  // Two faces back to back would have no smooth normal.
  for (const Vec3f& normal : smooth_normals(model)) EXPECT_EQ(normal.z, 1.0f);
  EXPECT_EQ(report.repeated_faces, 1u);
  const std::vector<std::string> warnings = warnings_of(report);
  EXPECT_TRUE(std::any_of(warnings.begin(), warnings.end(), [](const std::string& text) {
    return text.find("1 face of the scan was left out") != std::string::npos;
  })) << testing::PrintToString(warnings);
}

}  // namespace
}  // namespace ohb
