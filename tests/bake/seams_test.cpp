// Seams: what is measured, what the background beside them holds, and that both sides agree in the end.
#include "bake/seams.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <random>

#include "bake/seam_mend.h"
#include "tests/bake/two_charts.h"

namespace ohb {
using namespace bake;
using namespace surface;
namespace {

TEST(Seams, AreTheEdgesWithTwoPlaces) {
  const TwoCharts charts(64, 30, false);
  EXPECT_EQ(charts.seams.size(), 8u);
  for (const Seam& seam : charts.seams)
    for (const SeamSide& side : seam.side) EXPECT_NE(side.uv[0].y, side.uv[1].y);
  const Model whole = height_field(8, 10, [](float, float) { return 0.0f; });
  std::vector<uint32_t> all(whole.triangles.size());
  for (uint32_t t = 0; t < all.size(); ++t) all[t] = t;
  EXPECT_TRUE(find_seams(whole, all, nullptr).empty());
}

TEST(Seams, ErrorIsWhatTheSidesDifferBy) {
  const TwoCharts charts(64, 0, false);
  // The left chart holds .5, the right .5 + 10/255, both far into the background.
  Image map(64, 64, 1);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) *map.pixel(x, y) = x < 31 ? 0.5f : 0.5f + 10.0f / 255;
  const std::vector<SeamError> errors = seam_errors(map, charts.seams, MapValues::kPlain);
  ASSERT_EQ(errors.size(), size_t{kSeamLevels});
  EXPECT_NEAR(errors[0].max * 255, 10, 1e-3);
  EXPECT_NEAR(errors[0].mean * 255, 10, 1e-3);
  EXPECT_EQ(errors[0].share_above, 1);
  for (float& value : map.values) value = 0.7f;
  for (const SeamError& error : seam_errors(map, charts.seams, MapValues::kPlain)) EXPECT_LT(error.max, 1e-6);
}

TEST(Seams, TheBandGoesOnOnTheSurface) {
  for (bool is_mirrored : {false, true})
    for (float degrees : {0.0f, 33.0f, 90.0f}) {
      const TwoCharts charts(256, degrees, is_mirrored);
      const Image colour = charts.filled(charts.map_of(smooth_colour), false);
      const Image normal = charts.filled(charts.map_of(steady_normal), true);
      const auto colours = seam_errors(colour, charts.seams, MapValues::kLinearColour);
      const auto normals = seam_errors(normal, charts.seams, MapValues::kNormals);
      Image plain_colour = charts.map_of(smooth_colour), plain_normal = charts.map_of(steady_normal);
      pad(plain_colour, charts.is_covered);
      pad_normals(plain_normal, charts.is_covered);
      const auto plain_colours = seam_errors(plain_colour, charts.seams, MapValues::kLinearColour);
      const auto plain_normals = seam_errors(plain_normal, charts.seams, MapValues::kNormals);
      // Means, since at the ends of the seam the blocks of coarse levels reach past the open border.
      for (int level = 0; level < kSeamLevels; ++level) {
        EXPECT_LT(colours[level].mean * 255, level < 4 ? 1 : 2.5) << degrees << is_mirrored << level;
        EXPECT_LT(normals[level].mean, 1) << degrees << is_mirrored << level;
      }
      // Pull-push alone does not know the other chart.
      EXPECT_GT(plain_colours[3].mean, 2 * colours[3].mean);
      EXPECT_GT(plain_normals[3].mean, 2 * normals[3].mean);
    }
}

TEST(Seams, TheBandOfSeveralChannelsIsThatOfEach) {
  const TwoCharts charts(64, 33, true);
  const SeamBand band(charts.seams, charts.is_covered, 64, 64);
  std::mt19937 random(5);
  for (const int channels : {2, 3, 4, 5}) {
    Image all(64, 64, channels);
    for (float& value : all.values) value = static_cast<float>(random() % 1000) / 1000;
    const Image before = all;
    const std::vector<uint8_t> filled = band.fill(all, charts.is_covered, false);
    EXPECT_NE(all.values, before.values);
    for (int c = 0; c < channels; ++c) {
      Image one(64, 64, 1);
      for (size_t i = 0; i < one.values.size(); ++i) one.values[i] = before.values[i * channels + c];
      EXPECT_EQ(band.fill(one, charts.is_covered, false), filled);
      for (size_t i = 0; i < one.values.size(); ++i)
        ASSERT_EQ(all.values[i * channels + c], one.values[i]) << channels << " " << c << " " << i;
    }
  }
}

TEST(Seams, MendingMakesNoisyChartsAgree) {
  const TwoCharts charts(256, 33, true);
  std::mt19937 random(4);
  std::uniform_real_distribution<float> any(-0.05f, 0.05f);
  Image colour = charts.filled(charts.map_of([&](Vec3f p, Vec3f t, Vec3f n, float s) {
    return smooth_colour(p, t, n, s) + Vec3f{any(random), any(random), any(random)};
  }),
                               false);
  const Image before = colour;
  EXPECT_GT(seam_errors(colour, charts.seams, MapValues::kLinearColour)[0].max * 255, 8);
  const float changed =
      SeamMender(charts.seams, charts.is_inside, 256, 256).mend(colour, MapValues::kLinearColour, 0.3f / 255);
  const auto after = seam_errors(colour, charts.seams, MapValues::kLinearColour);
  for (int level : {0, 1}) {
    EXPECT_LT(after[level].mean * 255, 0.5);
    EXPECT_LT(after[level].max * 255, 2);
  }
  float most = 0;
  for (size_t i = 0; i < colour.values.size(); ++i)
    if (charts.is_inside[i / 3]) most = std::max(most, std::fabs(colour.values[i] - before.values[i]));
  EXPECT_EQ(most, changed);
  EXPECT_LT(changed, 0.1f);  // no more than the noise

  Image normal = charts.filled(charts.map_of([&](Vec3f p, Vec3f t, Vec3f n, float s) {
    return normalised(steady_normal(p, t, n, s) + Vec3f{any(random), any(random), 0});
  }),
                               true);
  EXPECT_GT(seam_errors(normal, charts.seams, MapValues::kNormals)[0].max, 2);
  SeamMender(charts.seams, charts.is_inside, 256, 256).mend(normal, MapValues::kNormals, 0.004f);
  EXPECT_LT(seam_errors(normal, charts.seams, MapValues::kNormals)[0].max, 1);
  EXPECT_LT(seam_errors(normal, charts.seams, MapValues::kNormals)[1].max, 1);
}

TEST(Seams, MendingIsTheSameForAnyNumberOfThreads) {
  const TwoCharts charts(256, 33, true);
  std::mt19937 random(4);
  std::uniform_real_distribution<float> any(0, 1);
  const Image noise = charts.filled(charts.map_of([&](Vec3f, Vec3f, Vec3f, float) {
    return Vec3f{any(random), any(random), any(random)};
  }),
                                    false);
  std::vector<Image> mended;
  for (size_t threads : {1, 2, 5}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    mended.push_back(noise);
    SeamMender(charts.seams, charts.is_inside, 256, 256).mend(mended.back(), MapValues::kPlain, 1e-3f);
  }
  EXPECT_NE(mended[0].values, noise.values);
  EXPECT_EQ(mended[1].values, mended[0].values);
  EXPECT_EQ(mended[2].values, mended[0].values);
}

TEST(Seams, MendingLeavesWhatAgreesAlone) {
  const TwoCharts charts(128, 20, false);
  Image map(128, 128, 3);
  for (float& value : map.values) value = 0.25f;
  const Image before = map;
  EXPECT_EQ(SeamMender(charts.seams, charts.is_inside, 128, 128).mend(map, MapValues::kPlain, 1e-4f), 0);
  EXPECT_EQ(map.values, before.values);
}

}  // namespace
}  // namespace ohb
