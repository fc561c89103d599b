// Lights that are mixtures of those that were rendered.
#include "learner/light_mixture.h"

#include <gtest/gtest.h>

#include <set>

#include "test_samples.h"

namespace ohb {
using namespace learner;
namespace {

// Whatever is drawn, the picture is a sum of the sample's own, each times one factor a channel: a
// least-squares fit of two factors to every channel leaves nothing over.
TEST(LightMixture, IsALinearCombinationOfTheSamplesLightsAChannelAtATime) {
  const Sample sample = ball_sample(24, "ada", 0);
  int mixed = 0;
  std::set<std::string> names;
  for (uint64_t key = 1; key <= 200; ++key) {
    const SampleLight light = mixed_light(sample, key);
    names.insert(light.name);
    if (light.name.find(" and ") == std::string::npos) {
      EXPECT_EQ(light.radiance.values, sample.lights[light.name == "left" ? 0 : 1].radiance.values);
      continue;
    }
    ++mixed;
    for (int c = 0; c < 3; ++c) {
      double aa = 0, ab = 0, bb = 0, ay = 0, by = 0, yy = 0;
      for (size_t i = static_cast<size_t>(c); i < light.radiance.values.size(); i += 3) {
        const double a = sample.lights[0].radiance.values[i], b = sample.lights[1].radiance.values[i],
                     y = light.radiance.values[i];
        aa += a * a, ab += a * b, bb += b * b, ay += a * y, by += b * y, yy += y * y;
      }
      const double det = aa * bb - ab * ab, fa = (ay * bb - by * ab) / det, fb = (by * aa - ay * ab) / det;
      EXPECT_GE(fa, -1e-4);
      EXPECT_GE(fb, -1e-4);
      EXPECT_NEAR(yy - fa * ay - fb * by, 0, 1e-5 * yy);
    }
  }
  EXPECT_EQ(names.size(), 6u) << "left, right, and the four pairs";
  EXPECT_NEAR(mixed, 100, 32) << "half of 200 draws; 4.5 deviations of a fair coin";
}

// Half a stop either way: the ratio of two channels' means changes by no more than a factor of two.
TEST(LightMixture, ColoursStayWithinBounds) {
  Sample sample = ball_sample(24, "ada", 0);
  for (SampleLight& light : sample.lights)
    for (size_t p = 0; p < sample.mask.values.size(); ++p)
      for (int c = 0; c < 3; ++c) light.radiance.values[3 * p + c] = sample.mask.values[p];
  double least = 1, most = 1;
  for (uint64_t key = 1; key <= 300; ++key) {
    const SampleLight light = mixed_light(sample, key);
    const float* pixel = light.radiance.pixel(12, 12);
    least = std::min(least, static_cast<double>(pixel[0]) / pixel[2]);
    most = std::max(most, static_cast<double>(pixel[0]) / pixel[2]);
  }
  EXPECT_GE(least, 0.5 - 1e-4);
  EXPECT_LE(most, 2 + 1e-4);
  EXPECT_LT(least, 0.7);
  EXPECT_GT(most, 1.4);
}

}  // namespace
}  // namespace ohb
