// Bakes from a source where unwraps and meshes are bad: finite maps, right values where there is a right one,
// and words for the rest.
#include <gtest/gtest.h>

#include <cmath>

#include "bake/bake.h"
#include "tests/bake/test_scans.h"
#include "tests/support/test_files.h"

namespace ohb {
using namespace bake;
using namespace surface;
namespace {

constexpr MaterialTable kTable = {
    {{0.184f, 0.4f, 0.08f}, {0.239f, 0.5f, 0}, {0.263f, 0.85f, 0}, {0.224f, 0.25f, 0}}};

struct Result {
  Model model;
  BakeReport report;
};

Result bake_onto(const Model& low, const Model& high, int size_px, double max_missed_share = 0.001) {
  const Scan scan = scan_of_model(low, "low.obj"), source = scan_of_model(high, "high.obj");
  BakeOptions options;
  options.size_px = size_px;
  options.source.scan = &source;
  options.source.max_missed_share = max_missed_share;
  Result result;
  result.model = bake_model(scan, one_class(scan), kTable, options, &result.report);
  for (const Image* image : {&result.model.sets[0].albedo, &result.model.sets[0].normal,
                             &result.model.sets[0].displacement, &result.model.sets[0].roughness})
    for (float value : image->values) EXPECT_TRUE(std::isfinite(value));
  for (size_t i = 0; i < result.model.sets[0].normal.values.size(); i += 3) {
    const float* const n = &result.model.sets[0].normal.values[i];
    EXPECT_NEAR(length(Vec3f{n[0], n[1], n[2]}), 1, 1e-3f);
  }
  return result;
}

float slope(float x, float y) {
  return 0.1f * x - 0.05f * y;
}

Model low_sheet(int cells = 6) {
  return height_field(cells, 100, [](float, float) { return 0.0f; });
}
Model high_sheet() {
  return height_field(60, 100, [](float x, float y) { return 0.1f * slope(x, y); });
}

TEST(BakeStress, OneComponentInsideAnother) {
  const auto ball = [](float radius) {
    Model model = sphere_model(radius, 64, TextureSet());
    for (Vec3f& p : model.positions_cm) p.y += 50 - radius;
    return model;
  };
  Model nested = ball(50);
  const Model inner = ball(49.5f);
  const uint32_t offset = static_cast<uint32_t>(nested.positions_cm.size());
  nested.positions_cm.insert(nested.positions_cm.end(), inner.positions_cm.begin(), inner.positions_cm.end());
  for (ModelTriangle triangle : inner.triangles) {
    for (uint32_t& p : triangle.position) p += offset;
    nested.triangles.push_back(triangle);
  }
  const Result result = bake_onto(ball(50), nested, 64, 0.05);
  EXPECT_GT(result.report.sets[0].hit_texels, 3500u);
  EXPECT_LT(result.report.sets[0].max_distance_cm, 0.1);  // never the inner one, 0.5 cm away
}

TEST(BakeStress, SliversAndChartsOfOneTexel) {
  Model low = low_sheet(8);
  // Each triangle a chart of its own: a third of them slivers in UV, a third smaller than a texel.
  low.uvs.clear();
  for (size_t t = 0; t < low.triangles.size(); ++t) {
    const Vec2f corner{0.01f + 0.085f * static_cast<float>(t % 11),
                       0.01f + 0.08f * static_cast<float>(t / 11)};
    const float width = t % 3 == 0 ? 0.06f : t % 3 == 1 ? 0.06f : 0.004f;
    const float height = t % 3 == 0 ? 0.06f : t % 3 == 1 ? 0.0005f : 0.004f;
    const Vec2f uvs[3] = {corner, corner + Vec2f{width, 0}, corner + Vec2f{0, height}};
    for (int c = 0; c < 3; ++c) {
      low.triangles[t].uv[c] = static_cast<uint32_t>(low.uvs.size());
      low.uvs.push_back(uvs[c]);
    }
  }
  const Result result = bake_onto(low, high_sheet(), 128);
  EXPECT_EQ(result.report.sets[0].triangles_without_texel, 0u);
  EXPECT_EQ(result.report.sets[0].missed_texels + result.report.sets[0].back_face_texels, 0u);
  // Each chart's texel shows the source over its own triangle, whatever the chart's size.
  for (size_t t = 0; t < low.triangles.size(); ++t) {
    const Vec2f uv = low.uvs[low.triangles[t].uv[0]];
    const Vec3f p = low.positions_cm[low.triangles[t].position[0]];
    const int x = static_cast<int>(uv.x * 128), row = 127 - static_cast<int>(uv.y * 128);
    const float z = *result.model.sets[0].displacement.pixel(x, row) - result.model.source_shift_cm.z;
    EXPECT_NEAR(z, 0.1f * slope(p.x, p.y), 0.3f) << t;  // within the triangle, 12 cm wide
  }
}

TEST(BakeStress, ZeroAreaUvsAndFinsAreReportedAndHarmless) {
  Model low = low_sheet();
  for (uint32_t& uv : low.triangles[7].uv) uv = low.triangles[7].uv[0];
  // A fin makes an edge of three triangles.
  low.positions_cm.push_back({50, 50, 4});
  low.uvs.push_back({0.5f, 0.5f});
  const uint32_t tip = static_cast<uint32_t>(low.positions_cm.size() - 1);
  ModelTriangle fin = low.triangles[20];
  fin.position[2] = tip;
  fin.uv[2] = static_cast<uint32_t>(low.uvs.size() - 1);
  low.triangles.push_back(fin);
  const Scan scan = scan_of_model(low, "low.obj"), source = scan_of_model(high_sheet(), "high.obj");
  BakeOptions options;
  options.size_px = 64;
  options.source.scan = &source;
  options.source.max_missed_share = 0.2;
  options.source.max_overlap_share = 1;
  BakeReport report;
  const Model model = bake_model(scan, one_class(scan), kTable, options, &report);
  EXPECT_EQ(report.sets[0].triangles_without_uv_area, 1u);
  for (float value : model.sets[0].normal.values) EXPECT_TRUE(std::isfinite(value));
  for (float value : model.sets[0].albedo.values) EXPECT_TRUE(std::isfinite(value));
  options.source.max_overlap_share = 0.001;
  expect_message(input_error_of([&] { bake_model(scan, one_class(scan), kTable, options); }),
                 {"--max-overlap"});
}

TEST(BakeStress, AMaskOfAnotherSizeIsSaid) {
  const TemporaryFolder folder;
  Image colour(16, 16, 3), mask(8, 8, 1);
  for (float& value : colour.values) value = 0.5f;
  for (float& value : mask.values) value = 1;
  write_png(folder / "colour.png", colour);
  write_png(folder / "mask.png", mask);
  Scan scan = scan_of_model(low_sheet(), "low.obj");
  scan.materials[0].diffuse = {folder / "colour.png", nullptr};
  scan.materials[0].alpha = {folder / "mask.png", nullptr};
  BakeReport report;
  const Model model = bake_model(scan, one_class(scan), kTable, {}, &report);
  EXPECT_EQ(model.sets[0].alpha.width_px, 16);
  ASSERT_EQ(warnings_of(report).size(), 1u);
  expect_message(warnings_of(report)[0], {"mask.png", "8 x 8 of 16 x 16", "export both in one size"});
}

}  // namespace
}  // namespace ohb
