// Which paths share candidates of the lights, and that what they share is the light.
#include "renderer/light_pools.h"

#include <gtest/gtest.h>

#include <cmath>

#include "renderer/render.h"
#include "sky_with_sun.h"

namespace ohb {
using namespace renderer;
namespace {

/// Radiance over pdf of the green channel, in the mean over all candidates of a pool.
double irradiance_of(const LightPool& pool) {
  double sum = 0;
  size_t count = 0;
  for (const LightCandidates& group : pool.groups())
    for (int k = 0; k < LightCandidates::kCount; ++k, ++count)
      if (group.pdf[k] > 0) sum += group.green[k] / group.pdf[k];
  return sum / static_cast<double>(count);
}

class LightPoolsTest : public ::testing::Test {
 protected:
  const std::shared_ptr<const LightSet> lights_ = prepare_lights({sky_with_sun(300), sky_with_sun(20)}, {});
  std::vector<LightPool> own_;

  LightPools pools(uint64_t seed = 1) const { return {*lights_, 0.3, seed, true}; }
  float first(LightPools& of, uint32_t sample, int pixel_class, TilePlace tile) {
    return of.at(PoolBlock::around(sample), pixel_class, tile, own_)[0].groups()[0].wi_x[0];
  }
};

TEST(PoolBlock, BlocksCoverAllSamplesWithoutGapOrOverlap) {
  uint32_t next = 0;
  while (next < 1000) {
    const PoolBlock block = PoolBlock::around(next);
    ASSERT_EQ(block.first, next);
    ASSERT_LE(block.end - block.first, PoolBlock::kLargest);
    for (uint32_t s = block.first; s < block.end; ++s) ASSERT_EQ(PoolBlock::around(s).end, block.end) << s;
    next = block.end;
  }
}

TEST_F(LightPoolsTest, AreSharedWithinARegionAndByNobodyElse) {
  LightPools some = pools(), same = pools(), other = pools(2);
  const float here = first(some, 20, 0, {16, 32});
  EXPECT_EQ(here, first(some, 31, 0, {240, 0})) << "one block, one region";
  EXPECT_EQ(here, first(some, 20, 0, {16, 512})) << "every second region has the same";
  EXPECT_NE(here, first(some, 20, 0, {256, 32}));
  EXPECT_NE(here, first(some, 20, 0, {16, 256}));
  EXPECT_NE(here, first(some, 20, 1, {16, 32})) << "classes share no random numbers";
  EXPECT_NE(here, first(some, 32, 0, {16, 32})) << "the next block";
  EXPECT_NE(here, first(other, 20, 0, {16, 32})) << "another seed";
  first(same, 5, 3, {512, 512});
  EXPECT_EQ(here, first(same, 20, 0, {16, 32})) << "whoever asked before";
  EXPECT_TRUE(own_.empty());
}

TEST_F(LightPoolsTest, TilesHaveTheirOwnFarOn) {
  LightPools some = pools();
  const float here = first(some, 1024, 0, {16, 32});
  EXPECT_EQ(own_.size(), 2u);
  EXPECT_EQ(here, first(some, 1087, 0, {16, 32}));
  EXPECT_NE(here, first(some, 1024, 0, {32, 32}));
  EXPECT_NE(here, first(some, 1088, 0, {16, 32}));
}

TEST_F(LightPoolsTest, ManyEnvironmentsDoNotFillTheMemory) {
  const auto some = prepare_lights(std::vector<Environment>(9, sky_with_sun(300)), {});
  LightPools nine(*some, 0, 1, true);
  EXPECT_EQ(first(nine, 20, 0, {0, 0}), first(nine, 20, 0, {256, 0})) << "one set for all regions";
  EXPECT_TRUE(own_.empty());
  const auto many = prepare_lights(std::vector<Environment>(33, sky_with_sun(300)), {});
  LightPools each(*many, 0, 1, true);
  EXPECT_NE(first(each, 20, 0, {0, 0}), first(each, 20, 0, {16, 0})) << "each tile its own";
  EXPECT_EQ(own_.size(), 33u);
}

TEST_F(LightPoolsTest, HoldTheLightsIrradiance) {
  // Each candidate's radiance over pdf is the same up to the ratio of a colour to the mean of all, so that
  // the mean over a pool has little noise; of 64 seeds none is more than five standard errors off in the
  // mean.
  for (size_t l = 0; l < 2; ++l) {
    double exact = 0;
    constexpr int kRows = 512;
    for (int j = 0; j < kRows; ++j)
      for (int i = 0; i < 2 * kRows; ++i) {
        const Vec2f uv{(i + 0.5f) / (2 * kRows), (j + 0.5f) / kRows};
        exact += lights_->environments[l].at(environment_direction(uv)).radiance.y * std::sin(M_PI * uv.y) *
                 2 * M_PI * M_PI / (2.0 * kRows * kRows);
      }
    constexpr int kSeeds = 64;
    double sum = 0, squares = 0;
    for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
      LightPools some = pools(seed);
      const double value = irradiance_of(some.at(PoolBlock::around(3), 0, {0, 0}, own_)[l]);
      sum += value, squares += value * value;
    }
    const double mean = sum / kSeeds, error = std::sqrt((squares / kSeeds - mean * mean) / (kSeeds - 1));
    EXPECT_NEAR(mean, exact, 5 * error + 1e-4 * exact) << l;
    EXPECT_LT(error * std::sqrt(kSeeds), 0.01 * exact) << "one pool alone is near it";
  }
}

/// Standard deviation over the seeds of a picture's mean, relative.
double error_of_mean(const Model& model, int spp, int seeds) {
  const auto scene = build_scene(model);
  const auto lights = prepare_lights({sky_with_sun(300)}, {});
  RenderSettings settings;
  settings.size_px = 8;
  settings.spp = spp;
  settings.max_bounces = 0;
  double sum = 0, squares = 0;
  for (int k = 0; k < seeds; ++k) {
    settings.seed = static_cast<uint64_t>(k) + 1;
    double mean = 0;
    const std::vector<SampleLight> images =
        render_lights({*scene, *lights, fit_camera(model.positions_cm), 0}, settings);
    for (const float v : images[0].radiance.values) mean += v;
    sum += mean, squares += mean * mean;
  }
  const double mean = sum / seeds;
  return std::sqrt((squares / seeds - mean * mean) * seeds / (seeds - 1)) / mean;
}

TEST(LightPools, WhatPathsShareDoesNotLimitThePicture) {
  // Sixteen times the paths, past those that share pools: were pools the same again and again, the mean's
  // error would stay; as it falls at least by the square root of 16, and the ratio of two deviations from 24
  // seeds lies within 2.3 of the true one (F, one in 10,000), below 1.7 is a fault.
  const Model ball = sphere_model(50, 48, constant_set({{0.7f, 0.5f, 0.3f}, 0.6f, 0.2f}));
  const double few = error_of_mean(ball, 256, 24), many = error_of_mean(ball, 4096, 24);
  EXPECT_GT(few / many, 4 / 2.3) << few << " " << many;
}

}  // namespace
}  // namespace ohb
