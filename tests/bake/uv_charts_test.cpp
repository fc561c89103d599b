#include "bake/uv_charts.h"

#include <gtest/gtest.h>

#include "tests/bake/test_scans.h"

namespace ohb {
using namespace bake;
using namespace surface;
namespace {

/// A sheet of 1 m whose right half is another chart, made `width` of the map wide.
struct TwoCharts {
  Model model = height_field(4, 100, [](float, float) { return 0.0f; });
  std::vector<uint32_t> triangles;
  std::vector<UvTriangle> uvs;
  explicit TwoCharts(float width, float shift = 0.5f) {
    for (uint32_t t = 0; t < model.triangles.size(); ++t) {
      UvTriangle uv;
      for (int c = 0; c < 3; ++c) uv.uv[c] = model.uvs[model.triangles[t].uv[c]];
      const bool is_right = uv.uv[0].x + uv.uv[1].x + uv.uv[2].x > 1.5f;
      for (Vec2f& p : uv.uv) p.x = is_right ? shift + 0.001f + (p.x - 0.5f) * width / 0.5f : p.x * 0.998f;
      triangles.push_back(t);
      uvs.push_back(uv);
    }
  }
};

TEST(UvCharts, SizesInTexelsAndInSpace) {
  const TwoCharts two(0.25f);
  const UvCharts charts = find_charts(two.model, two.triangles, two.uvs, 64, 128);
  ASSERT_EQ(charts.charts.size(), 2u);
  EXPECT_NEAR(charts.charts[0].width_texels, 0.998 * 32, 1e-3);
  EXPECT_NEAR(charts.charts[0].height_texels, 128, 1e-3);
  EXPECT_NEAR(charts.charts[1].width_texels, 16, 1e-3);
  EXPECT_NEAR(charts.charts[1].diagonal_cm, std::hypot(50, 100), 1e-3);
  EXPECT_EQ(charts.chart_of[0], 0u);
  EXPECT_EQ(charts.chart_of.back(), 1u);
}

TEST(UvCharts, SeamsOfThinAndHiddenChartsAreLeftAlone) {
  const auto kept_of = [](const TwoCharts& two) {
    const UvCharts charts = find_charts(two.model, two.triangles, two.uvs, 64, 64);
    return triangles_with_seams(charts, two.triangles, two.uvs, cover_texels(two.uvs, 64, 64)).size();
  };
  EXPECT_EQ(kept_of(TwoCharts(0.25f)), 32u);
  EXPECT_EQ(kept_of(TwoCharts(0.02f)), 16u) << "the right chart is 1.3 texels wide";
  EXPECT_EQ(kept_of(TwoCharts(0.25f, 0.1f)), 16u) << "the right chart lies under the left one";
}

}  // namespace
}  // namespace ohb
