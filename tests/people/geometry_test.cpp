// Packing, layers and hiding on shapes whose answer is known.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "dataset/people/atlas.h"
#include "dataset/people/checks.h"
#include "dataset/people/fused.h"
#include "dataset/people/random.h"
#include "dataset/people/visible_faces.h"
#include "dataset/people/voxel_wrap.h"

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

TEST(Layers, AHatPressesHairInFromFarAndSkinDoesNotFollow) {
  TwoSheets sheets(-4);  // as a brow lies above the brim seen along its normal
  sheets.item.slot = Slot::kHat;
  sheets.person.parts.insert(sheets.person.parts.begin() + 1, sheet(PartKind::kEyes, 1, -8));
  sheets.person.parts.push_back(sheet(PartKind::kHair, 10, 0));
  sheets.person.chin_cm = -100;
  settle_layers(sheets.person);
  for (const Vec3f& position : sheets.person.skin().posed_cm) EXPECT_EQ(position.z, 0);
  const Part& hair = sheets.person.parts.back();
  for (const Vec3f& position : hair.posed_cm) EXPECT_NEAR(position.z, -4.25f, 1e-4f);
  EXPECT_EQ(hair.faces.size(), 100u);
}

TEST(Layers, HairThatStandsOutOfAHatGoes) {
  TwoSheets sheets(-4);
  sheets.item.slot = Slot::kHat;
  sheets.person.parts.insert(sheets.person.parts.begin() + 1, sheet(PartKind::kEyes, 1, -8));
  sheets.person.parts.push_back(
      sheet(PartKind::kHair, 10, 3));  // 7 cm above the hat: too far to be pressed in
  sheets.person.chin_cm = -100;
  settle_layers(sheets.person);
  EXPECT_TRUE(sheets.person.parts.back().faces.empty());
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

/// A box of quads without its lid.
void open_box(std::vector<Vec3f>& positions, std::vector<SurfaceTriangle>& triangles) {
  for (int i = 0; i < 8; ++i)
    positions.push_back({i & 1 ? 5.0f : -5.0f, i & 2 ? 10.0f : 0.0f, i & 4 ? 5.0f : -5.0f});
  const uint32_t quads[5][4] = {{0, 1, 5, 4}, {0, 2, 3, 1}, {4, 5, 7, 6}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (uint32_t q = 0; q < 5; ++q) {
    triangles.push_back({{quads[q][0], quads[q][1], quads[q][2]}, q});
    triangles.push_back({{quads[q][0], quads[q][2], quads[q][3]}, q});
  }
}

double volume_of(const WrappedSurface& surface) {
  double volume = 0;
  for (const auto& q : surface.quads)
    for (const size_t k : {size_t{1}, size_t{2}})
      volume += static_cast<double>(dot(surface.positions_cm[q[0]],
                                        cross(surface.positions_cm[q[k]], surface.positions_cm[q[k + 1]]))) /
                6;
  return volume;
}

TEST(VoxelWrap, IsClosedAndLooksOutwards) {
  std::vector<Vec3f> positions;
  std::vector<SurfaceTriangle> triangles;
  open_box(positions, triangles);
  // With its lid the box is solid: 10 x 10 x 10, and a voxel all around.
  triangles.push_back({{2, 6, 7}, 5}), triangles.push_back({{2, 7, 3}, 5});
  constexpr float kVoxel = .5f;
  const WrappedSurface closed = wrap(positions, triangles, kVoxel);
  const double with_shell = std::pow(10 + 2 * static_cast<double>(kVoxel), 3);
  EXPECT_NEAR(volume_of(closed), with_shell, .03 * with_shell);
  std::map<std::pair<uint32_t, uint32_t>, int> forward;
  for (const auto& q : closed.quads)
    for (size_t k = 0; k < 4; ++k) {
      const uint32_t a = q[k], b = q[(k + 1) % 4];
      forward[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
  for (const auto& [edge, sum] : forward) ASSERT_EQ(sum, 0) << "an edge with one side only";
  // Without it the walls alone are solid, on both sides.
  triangles.resize(triangles.size() - 2);
  EXPECT_LT(volume_of(wrap(positions, triangles, kVoxel)), .6 * with_shell);
}

TEST(Fused, KeepsClassesAndPlaces) {
  std::vector<SurfaceTriangle> triangles;
  ScannedPerson scan;
  open_box(scan.positions_cm, triangles);
  for (const SurfaceTriangle& triangle : triangles) {
    scan.face_begin.push_back(static_cast<uint32_t>(scan.corners.size()));
    for (const uint32_t corner : triangle.corner) scan.corners.push_back({corner, 0});
    scan.face_class.push_back(triangle.face == 0 ? kLeather : kFabric);
    scan.part_of_face.push_back("box");
  }
  scan.face_begin.push_back(static_cast<uint32_t>(scan.corners.size()));
  scan.uvs.push_back({.5f, .5f});
  scan.picture = ByteImage(256, 256, 3);
  std::fill(scan.picture.values.begin(), scan.picture.values.end(), uint8_t{77});
  const ScannedPerson one = fused(scan, .5f);
  EXPECT_GT(one.face_count(), 1500u);
  for (const Vec3f& p : one.positions_cm) {
    const float outside = std::max({std::fabs(p.x) - 5, std::fabs(p.z) - 5, -p.y, p.y - 10});
    EXPECT_LT(outside, .2f) << "drawn back to within a fifth of its shell";
  }
  size_t leather = 0;
  for (size_t face = 0; face < one.face_count(); ++face) {
    const Vec3f at = one.positions_cm[one.corners[one.face_begin[face]].position];
    leather += one.face_class[face] == kLeather;
    EXPECT_TRUE(one.face_class[face] != kLeather || at.y < 1.5f);
  }
  EXPECT_GT(leather, 300u);
  for (const Vec2f uv : one.uvs) EXPECT_TRUE(uv.x >= 0 && uv.x <= 1 && uv.y >= 0 && uv.y <= 1);
  for (const uint8_t value : one.picture.values) ASSERT_EQ(value, 77);
  EXPECT_EQ(fused(scan, .5f).picture.values, one.picture.values);
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
