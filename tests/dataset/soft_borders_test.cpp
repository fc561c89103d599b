#include "dataset/labelling/soft_borders.h"

#include <gtest/gtest.h>

#include "bake/bake.h"
#include "dataset/commands/bake_scan.h"
#include "dataset/commands/label.h"
#include "dataset/model/data_files.h"
#include "tests/support/scan_files.h"
#include "tests/support/test_files.h"

namespace ohb {
using namespace bake;
using namespace commands;
using namespace labelling;
using namespace surface;
namespace {

/// A strip of n quads of `edge` along X, 1 high, in the plane z = 0.
Scan strip(int n, float edge) {
  Scan scan;
  scan.materials.resize(1);
  scan.groups = {"strip"};
  for (int i = 0; i <= n; ++i)
    for (float y : {0.0f, 1.0f}) scan.positions.push_back({static_cast<float>(i) * edge, y, 0});
  scan.face_begin = {0};
  for (int i = 0; i < n; ++i) {
    for (int index : {2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1})
      scan.corners.push_back({static_cast<uint32_t>(index), Corner::kNoUv});
    scan.face_begin.push_back(static_cast<uint32_t>(scan.corners.size()));
    scan.face_material.push_back(0);
    scan.face_group.push_back(0);
  }
  return scan;
}

TEST(SoftBorders, AreAsWideAsTheirPairOfClassesInAnyUnitAndFineness) {
  std::vector<std::pair<uint8_t, uint8_t>> pairs;  // each class on both sides
  for (uint8_t c = 0; c < kClassCount; ++c) pairs.emplace_back(c, (c + 1) % kClassCount);
  for (const auto& [left, right] : pairs)
    for (const double unit_cm : {1.0, 2.54})
      for (const int faces_of_cm : {1, 3, 40}) {
        const int n = 2 * faces_of_cm;
        const auto edge = static_cast<float>(1 / (faces_of_cm * unit_cm));
        const Scan scan = strip(n, edge);
        std::vector<uint8_t> face_class(static_cast<size_t>(n), left);
        std::fill(face_class.begin() + faces_of_cm, face_class.end(), right);
        const SoftBorders borders({scan, unit_cm}, face_class);
        const double width = kBorderWidth_cm[left][right];
        for (double x_cm = 0.013; x_cm < 2; x_cm += 0.02) {
          const auto face = static_cast<uint32_t>(x_cm * faces_of_cm);
          const ClassValues shares =
              borders.shares_at(face, face_class[face], {static_cast<float>(x_cm / unit_cm), 0.5f, 0});
          const double expected = std::clamp(0.5 + (x_cm - 1) / width, 0.0, 1.0);
          ASSERT_NEAR(shares[right], expected, 1e-4)
              << int{left} << int{right} << " " << unit_cm << " " << faces_of_cm << " " << x_cm;
          ASSERT_NEAR(shares[left], 1 - expected, 1e-4);
        }
      }
}

TEST(SoftBorders, SumToOneWhereThreeClassesMeetAndKeepTheOwnClassFirst) {
  // Three triangles around a point.
  Scan scan = strip(1, 1);
  scan.positions = {{0, 0, 0}, {1, 0, 0}, {-0.5f, 0.9f, 0}, {-0.5f, -0.9f, 0}};
  scan.corners.clear();
  scan.face_begin = {0};
  for (uint32_t i = 0; i < 3; ++i) {
    for (uint32_t p : {0u, 1 + i, 1 + (i + 1) % 3}) scan.corners.push_back({p, Corner::kNoUv});
    scan.face_begin.push_back(static_cast<uint32_t>(scan.corners.size()));
  }
  scan.face_material.assign(3, 0);
  scan.face_group.assign(3, 0);
  const SoftBorders borders({scan, 1}, {kSkin, kHair, kFabric});
  const ClassValues middle = borders.shares_at(0, kSkin, {0, 0, 0});
  for (int c : {0, 1, 2}) EXPECT_NEAR(middle[c], 1.0f / 3, 1e-5f);
  const ClassValues near = borders.shares_at(0, kSkin, {0.1f, 0.1f, 0});
  EXPECT_GT(near[kSkin], 0.5f);
  EXPECT_NEAR(near[0] + near[1] + near[2] + near[3], 1, 1e-6f);
}

TEST(SoftBorders, DoNotReachThroughAThinSheet) {
  // Two strips 0.1 apart that do not touch: the lower one is skin, the upper one half hair, half fabric.
  Scan scan = strip(4, 0.5f);
  const auto points = static_cast<uint32_t>(scan.positions.size());
  for (uint32_t i = 0; i < points; ++i) scan.positions.push_back(scan.positions[i] + Vec3f{0, 0, 0.1f});
  for (size_t c = 0; c < 16; ++c) scan.corners.push_back({scan.corners[c].position + points, Corner::kNoUv});
  for (int f = 0; f < 4; ++f) scan.face_begin.push_back(scan.face_begin.back() + 4);
  scan.face_material.assign(8, 0);
  scan.face_group.assign(8, 0);
  const SoftBorders borders({scan, 1}, {kSkin, kSkin, kSkin, kSkin, kHair, kHair, kFabric, kFabric});
  EXPECT_EQ(borders.shares_at(1, kSkin, {0.99f, 0.5f, 0})[kSkin], 1);
  EXPECT_NEAR(borders.shares_at(5, kHair, {0.99f, 0.5f, 0.1f})[kFabric], 0.5f - 0.01f / 0.3f, 1e-4f);
}

TEST(SoftBorders, BakeMixesTheValuesThatTheWeightsSay) {
  const TemporaryFolder folder;
  // A square of 30 cm of two halves; 256 texels: 1.2 mm each, so hair to skin is 7 texels wide.
  write_bytes(folder / "s.obj",
              "mtllib s.mtl\nusemtl a\nv 0 0 0\nv 15 0 0\nv 30 0 0\nv 0 30 0\nv 15 30 0\nv 30 30 0\n"
              "vt 0 0\nvt 0.5 0\nvt 1 0\nvt 0 1\nvt 0.5 1\nvt 1 1\nf 1/1 2/2 5/5 4/4\nf 2/2 3/3 6/6 5/5\n");
  write_bytes(folder / "s.mtl", "newmtl a\nmap_Kd p.png\n");
  write_small_png(folder / "p.png", 3, 256);
  LabelJob label;
  label.scan = folder / "s.obj";
  label.faces = write_bytes(folder / "f.txt", "1\n0\n");
  label.unit = "cm";
  label.output = folder / "regions";
  label_scan(label);
  BakeJob bake;
  bake.scan = label.scan;
  bake.regions = label.output;
  bake.output = folder / "model";
  bake.unit = "cm";
  bake.quiet = true;
  bake_scan(bake);
  const MaterialTable table = read_material_table(program_file("assets/materials.xml"));
  const Model soft = read_model(bake.output);
  int mixed = 0;
  for (int x = 110; x < 146; ++x) {
    const double x_cm = (x + 0.5) * 30 / 256;
    const double skin = std::clamp(0.5 + (x_cm - 15) / 0.8, 0.0, 1.0);
    const float expected =
        static_cast<float>(skin * table[kSkin].roughness + (1 - skin) * table[kHair].roughness);
    EXPECT_NEAR(*soft.sets[0].roughness.pixel(x, 70), expected, 1e-3f) << x;
    EXPECT_NEAR(*soft.sets[0].sss.pixel(x, 70), skin * table[kSkin].sss + (1 - skin) * table[kHair].sss,
                1e-3f)
        << x;
    mixed += skin > 0 && skin < 1;
  }
  EXPECT_GE(mixed, 6);
  // Weights that are no numbers are no weights.
  const std::filesystem::path weights = folder / "regions/maps/a/weights.exr";
  std::vector<ExrPart> parts = read_exr(weights);
  parts[0].image.values[5] = std::nanf("");
  write_exr(weights, parts, {});
  expect_message(input_error_of([&] { bake_scan(bake); }),
                 {"weights.exr", "part 'weights'", "no numbers", "run `label` again"});
  // Without the weights the border is that of the faces.
  std::filesystem::remove(weights);
  bake_scan(bake);
  const Model hard = read_model(bake.output);
  EXPECT_NEAR(*hard.sets[0].roughness.pixel(127, 70), table[kHair].roughness, 1e-3f);
  EXPECT_NEAR(*hard.sets[0].roughness.pixel(128, 70), table[kSkin].roughness, 1e-3f);
}

}  // namespace
}  // namespace ohb
