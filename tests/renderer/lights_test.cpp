// Environment lookup and sampling.
#include "renderer/lights.h"

#include <gtest/gtest.h>

#include "chi_squared.h"
#include "tests/support/test_models.h"

namespace ohb {
using namespace renderer;
namespace {

Environment environment_of(const Image& image) {
  Environment environment;
  environment.name = "test";
  environment.radiance = image;
  return environment;
}

Image random_radiance(int height_px, uint64_t seed, float sun) {
  Image image(2 * height_px, height_px, 3);
  Random random(seed, 0, 0);
  for (float& v : image.values) v = random.next();
  for (int c = 0; c < 3; ++c) image.pixel(height_px / 3, height_px / 4)[c] = sun;
  return image;
}

TEST(PiecewiseConstant, InvertsItsDistribution) {
  const PiecewiseConstant table({1, 0, 3, 0, 0, 4, 2, 0});
  EXPECT_DOUBLE_EQ(table.total(), 10);
  const double cdf[] = {0, .1, .1, .4, .4, .4, .8, 1, 1};
  float rest;
  for (int i = 0; i < 100000; ++i) {
    const float u = static_cast<float>(i) / 100000;
    const int cell = table.sample(u, rest);
    ASSERT_GE(u, cdf[cell] - 1e-6);
    ASSERT_LE(u, cdf[cell + 1] + 1e-6);
    ASSERT_GT(table.probability(cell), 0);
    ASSERT_NEAR(cdf[cell] + rest * (cdf[cell + 1] - cdf[cell]), u, 1e-5);
  }
}

TEST(EnvironmentLight, DirectionAndTexelAreInverse) {
  for (const Vec3f d : {Vec3f{1, 0, 0}, Vec3f{0, 0, 1}, normalised(Vec3f{-.3f, .5f, .2f})}) {
    const Vec3f back = environment_direction(environment_uv(d));
    EXPECT_NEAR(length(back - d), 0, 1e-5);
  }
  // As in Cycles, with its axes (x, -z, y): the image centre is +X, +Z (the face) is at three quarters.
  EXPECT_NEAR(environment_uv({1, 0, 0}).x, 0.5f, 1e-6);
  EXPECT_NEAR(environment_uv({0, 0, 1}).x, 0.75f, 1e-6);
  EXPECT_NEAR(environment_uv({0, 1, 0}).y, 0, 1e-6);
}

TEST(EnvironmentLight, SamplerFollowsItsPdf) {
  const double limit = 1 - std::pow(1 - 0.01, 1.0 / 4);
  for (const float sun : {1.f, 10.f, 100.f, 1e4f}) {
    constexpr int kRows = 32, kColumns = 64, kCount = 1000000;
    const EnvironmentLight light(environment_of(random_radiance(kRows, 3, sun)));
    // pdf sin(theta) is bilinear over a quarter of a texel: its value at the centre of each gives the
    // texel's probability.
    std::vector<double> expected(kRows * kColumns), observed(kRows * kColumns, 0.0);
    double integral = 0;
    for (int y = 0; y < kRows; ++y)
      for (int x = 0; x < kColumns; ++x) {
        for (int quarter = 0; quarter < 4; ++quarter) {
          const float u = (x + 0.25f + 0.5f * (quarter & 1)) / kColumns,
                      v = (y + 0.25f + 0.5f * (quarter >> 1)) / kRows;
          expected[y * kColumns + x] += 0.25 * light.at(environment_direction({u, v})).pdf *
                                        std::sin(M_PI * v) * 2 * M_PI * M_PI / (kRows * kColumns);
        }
        integral += expected[y * kColumns + x];
      }
    EXPECT_NEAR(integral, 1, 1e-4) << sun;
    Random random(17, 0, 0);
    int across_a_border = 0;  // float rounding on the border of two texels
    for (int n = 0; n < kCount; ++n) {
      const float u1 = random.next(), u2 = random.next();
      const LightSample s = light.sample(u1, u2);
      if (std::fabs(s.pdf - light.at(s.wi).pdf) > 2e-3f * s.pdf) ++across_a_border;
      const Vec2f uv = environment_uv(s.wi);
      ++observed[std::min(kRows - 1, static_cast<int>(uv.y * kRows)) * kColumns +
                 std::min(kColumns - 1, static_cast<int>(uv.x * kColumns))];
    }
    EXPECT_LT(across_a_border, kCount / 1000) << "the pdf of a sample is the pdf of its direction";
    EXPECT_GT(pooled_chi_squared_p_value(expected, observed, kCount), limit) << sun;
  }
}

TEST(EnvironmentLight, SamplesIntegrateTheMap) {
  const EnvironmentLight light(environment_of(random_radiance(32, 9, 5000)));
  double brute = 0;
  constexpr int kRows = 800;
  for (int j = 0; j < kRows; ++j)
    for (int i = 0; i < 2 * kRows; ++i) {
      const Vec2f uv{(i + 0.5f) / (2 * kRows), (j + 0.5f) / kRows};
      brute += mean(light.at(environment_direction(uv)).radiance) * std::sin(M_PI * uv.y) * 2 * M_PI * M_PI /
               (2.0 * kRows * kRows);
    }
  Random random(1, 2, 3);
  double sum = 0, squares = 0;
  constexpr int kCount = 400000;
  for (int i = 0; i < kCount; ++i) {
    const float u1 = random.next(), u2 = random.next();
    const LightSample s = light.sample(u1, u2);
    EXPECT_NEAR(length(s.wi), 1, 1e-5);
    const double value = s.pdf > 0 ? mean(s.radiance) / s.pdf : 0;
    sum += value;
    squares += value * value;
  }
  const double mean_value = sum / kCount,
               error = std::sqrt((squares / kCount - mean_value * mean_value) / kCount);
  EXPECT_NEAR(mean_value, brute, 5 * error + 1e-3 * brute);
}

TEST(EnvironmentLight, LightComesOnlyFromWhereThePdfIsPositive) {
  Image image(16, 8, 3);
  for (int c = 0; c < 3; ++c) image.pixel(5, 3)[c] = 1e6f;
  const EnvironmentLight light(environment_of(image));
  Random random(4, 4, 4);
  for (int i = 0; i < 200000; ++i) {
    const float u1 = random.next(), u2 = random.next();
    const Vec3f d = environment_direction({u1, u2});
    if (max_component(light.at(d).radiance) > 0) {
      EXPECT_GT(light.at(d).pdf, 0);
    }
  }
}

}  // namespace
}  // namespace ohb
