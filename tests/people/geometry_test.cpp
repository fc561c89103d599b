// Packing, layers and hiding on shapes whose answer is known.
#include <gtest/gtest.h>

#include "dataset/people/atlas.h"
#include "dataset/people/checks.h"
#include "dataset/people/random.h"
#include "dataset/people/visible_faces.h"

namespace ohb::people {
namespace {

TEST(PackBoxes, FitWithoutOverlap) {
  Random random(3, "boxes");
  std::vector<Vec2f> sizes;
  for (int i = 0; i < 300; ++i) sizes.push_back({random.within(1, 9), random.within(1, 9)});
  const std::vector<Vec2f> places = pack_boxes(sizes, 110);
  ASSERT_EQ(places.size(), sizes.size());
  for (size_t a = 0; a < sizes.size(); ++a) {
    EXPECT_LE(places[a].x + sizes[a].x, 110);
    EXPECT_LE(places[a].y + sizes[a].y, 110);
    for (size_t b = 0; b < a; ++b) {
      const bool apart = places[a].x + sizes[a].x <= places[b].x || places[b].x + sizes[b].x <= places[a].x ||
                         places[a].y + sizes[a].y <= places[b].y || places[b].y + sizes[b].y <= places[a].y;
      EXPECT_TRUE(apart) << a << " and " << b;
    }
  }
  EXPECT_TRUE(pack_boxes(sizes, 60).empty()) << "more area than the square has";
}

TEST(SurfaceQuery, NearestPointAndRayAgreeWithTheTriangle) {
  const SurfaceQuery one({{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}, {{{0, 1, 2}, 7}});
  const SurfaceHit near = one.nearest({1, 1, 3}, 10);
  ASSERT_TRUE(near.found);
  EXPECT_FLOAT_EQ(near.distance_cm, 3);
  EXPECT_FLOAT_EQ(near.normal.z, 1);
  EXPECT_FALSE(one.nearest({1, 1, 3}, 2).found);
  const SurfaceHit corner = one.nearest({-3, -4, 0}, 10);
  EXPECT_FLOAT_EQ(corner.distance_cm, 5);
  const SurfaceHit hit = one.first_hit({1, 1, -2}, {0, 0, 1}, 5);
  ASSERT_TRUE(hit.found);
  EXPECT_FLOAT_EQ(hit.distance_cm, 2);
  EXPECT_FALSE(one.first_hit({3, 3, -2}, {0, 0, 1}, 5).found);
}

/// A grid of quads in the plane z = height, facing +Z.
Part sheet(PartKind kind, float half_size, float height) {
  auto mesh = std::make_shared<Scan>();
  constexpr int kCells = 10;
  for (int y = 0; y <= kCells; ++y)
    for (int x = 0; x <= kCells; ++x) {
      mesh->positions.push_back({half_size * (static_cast<float>(2 * x) / kCells - 1),
                                 half_size * (static_cast<float>(2 * y) / kCells - 1), height});
      mesh->uvs.push_back({static_cast<float>(x) / kCells, static_cast<float>(y) / kCells});
    }
  for (int y = 0; y < kCells; ++y)
    for (int x = 0; x < kCells; ++x) {
      mesh->face_begin.push_back(static_cast<uint32_t>(mesh->corners.size()));
      const auto at = [&](int i, int j) { return static_cast<uint32_t>((y + j) * (kCells + 1) + x + i); };
      for (const uint32_t v : {at(0, 0), at(1, 0), at(1, 1), at(0, 1)}) mesh->corners.push_back({v, v});
    }
  mesh->face_begin.push_back(static_cast<uint32_t>(mesh->corners.size()));
  Part part;
  part.kind = kind;
  part.rest_cm = part.posed_cm = mesh->positions;
  part.bones.resize(part.rest_cm.size());
  for (uint32_t face = 0; face < mesh->face_count(); ++face) part.faces.push_back(face);
  part.mesh = mesh;
  return part;
}

struct TwoSheets {
  WornItem item;
  Person person;
  std::shared_ptr<Garment> garment = std::make_shared<Garment>();

  /// Skin at z = 0 under cloth of twice its size at `cloth_cm`, in the pose; at rest the cloth is 1 cm above.
  explicit TwoSheets(float cloth_cm) {
    person.parts.push_back(sheet(PartKind::kSkin, 10, 0));
    Part cloth = sheet(PartKind::kClothes, 20, 1);
    for (Vec3f& position : cloth.posed_cm) position.z = cloth_cm;
    garment->hides.assign(person.parts[0].rest_cm.size(), 0);
    cloth.garment = garment;
    cloth.worn = &item;
    cloth.name = "cloth";
    person.parts.push_back(std::move(cloth));
    person.parts[0].name = "skin";
  }
};

TEST(Layers, SkinThatComesThroughIsPressedUnder) {
  TwoSheets sheets(-1.5f);
  const Pokes before = find_pokes(sheets.person);
  EXPECT_NEAR(before.depth_cm, 1.5f, 1e-4f);
  EXPECT_NEAR(before.area_cm2, 400, 1e-2f);
  EXPECT_EQ(before.worst, "skin through cloth");
  settle_layers(sheets.person);
  EXPECT_EQ(find_pokes(sheets.person).depth_cm, 0);
  for (const Vec3f& position : sheets.person.skin().posed_cm) EXPECT_NEAR(position.z, -1.75f, 1e-4f);
}

TEST(Layers, SkinThatLiesUnderStaysWhereItIs) {
  TwoSheets sheets(1);
  settle_layers(sheets.person);
  for (const Vec3f& position : sheets.person.skin().posed_cm) EXPECT_EQ(position.z, 0);
}

TEST(Layers, WhatAGarmentHidesGoesOnlyWhereItLiesOverIt) {
  TwoSheets sheets(1);
  std::fill(sheets.garment->hides.begin(), sheets.garment->hides.end(), char{1});
  settle_layers(sheets.person);
  EXPECT_TRUE(sheets.person.skin().faces.empty());
  TwoSheets beside(1);
  std::fill(beside.garment->hides.begin(), beside.garment->hides.end(), char{1});
  for (Vec3f& position : beside.person.parts[1].rest_cm) position.x += 100;
  settle_layers(beside.person);
  EXPECT_EQ(beside.person.skin().faces.size(), 100u);
}

TEST(VisibleFaces, SkinBetweenTwoSheetsIsDroppedButForItsRim) {
  TwoSheets sheets(.3f);
  sheets.person.parts.push_back(sheet(PartKind::kClothes, 20, -.3f));
  sheets.person.parts.back().garment = sheets.garment, sheets.person.parts.back().worn = &sheets.item;
  const size_t dropped = drop_unseen_faces(sheets.person);
  EXPECT_GT(dropped, 60u);
  EXPECT_EQ(sheets.person.parts[1].faces.size(), 100u);
  EXPECT_EQ(sheets.person.parts[2].faces.size(), 100u);
}

TEST(Hair, SplitFacesKeepTheirSurfaceAndEmptyOnesGo) {
  Part hair = sheet(PartKind::kHair, 10, 0);
  const size_t positions = hair.rest_cm.size();
  split_faces(hair);
  EXPECT_EQ(hair.faces.size(), 400u);
  EXPECT_EQ(hair.rest_cm.size(), positions + 220 + 100) << "middles of 220 edges and 100 faces, shared";
  float area = 0;
  for (const SurfaceTriangle& t : triangles_of(hair)) {
    const Vec3f a = hair.posed_cm[t.corner[0]];
    area += .5f * length(cross(hair.posed_cm[t.corner[1]] - a, hair.posed_cm[t.corner[2]] - a));
  }
  EXPECT_NEAR(area, 400, .01f);
  drop_empty_faces(hair, [](Vec2f uv) { return uv.x < .5f ? 1.0f : 0.0f; });
  EXPECT_EQ(hair.faces.size(), 200u);
}

TEST(Verdict, NamesWhatIsWrong) {
  PersonFaults faults;
  EXPECT_EQ(faults.verdict(), "");
  faults.hair_gap_cm = 5;
  EXPECT_NE(faults.verdict().find("hair floats 5.0 cm"), std::string::npos);
  faults.limb_depth_cm = 4, faults.limb_vertices = 100;
  EXPECT_NE(faults.verdict().find("a limb lies 4.0 cm deep"), std::string::npos);
}

}  // namespace
}  // namespace ohb::people
