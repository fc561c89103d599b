// The statistics of `validate` on synthetic images whose truth is known.
#include "renderer/validation/statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace ohb {
using namespace validation;
namespace {

constexpr int kSize = 60;  // 400 bins of 3 x 3 px

/// A smooth scene of mean about 0.5, in three unequal channels.
float truth(int x, int y, int c) {
  return (0.5f + 0.3f * std::sin(0.2f * x) * std::cos(0.13f * y)) * (1.0f - 0.25f * c);
}

struct Noise {
  double sigma;     // of the logarithm: 0.1 is tame, 1.5 is full of fireflies
  double gain = 1;  // in x < kSize / 2
  int shift_px = 0;
};

/// K seeds with multiplicative log-normal noise of mean 1.
ImageStack render(int seeds, const Noise& noise, uint32_t random_seed) {
  std::mt19937 random(random_seed);
  std::normal_distribution<double> normal;
  ImageStack stack;
  for (int k = 0; k < seeds; ++k) {
    Image image(kSize, kSize, 4);
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x)
        for (int c = 0; c < 3; ++c) {
          const double factor = std::exp(noise.sigma * normal(random) - 0.5 * noise.sigma * noise.sigma);
          const double gain = x < kSize / 2 ? noise.gain : 1;
          image.pixel(x, y)[c] = static_cast<float>(gain * factor * truth(x + noise.shift_px, y, c));
        }
    stack.push_back(image);
  }
  return stack;
}

std::vector<uint8_t> all_pixels() {
  return std::vector<uint8_t>(kSize * kSize, 1);
}

std::vector<float> left_half() {
  std::vector<float> weights(kSize * kSize, 0.0f);
  for (int i = 0; i < kSize * kSize; ++i) weights[i] = i % kSize < kSize / 2;
  return weights;
}

// Under equal truth a bin is rejected in at most alpha = 1 % of all runs: of 100 runs 1 is expected, and more
// than 6 have a chance of 2e-5.
TEST(Statistics, FalseAlarmsAreAsRareAsClaimed) {
  for (const double sigma : {0.2, 0.8, 1.5}) {
    int alarms = 0;
    for (uint32_t run = 0; run < 100; ++run) {
      const BinTest test =
          test_bins(render(8, {sigma}, 2 * run), render(8, {sigma}, 2 * run + 1), all_pixels());
      ASSERT_EQ(test.bins, 400u);
      alarms += test.accepted < test.bins;
    }
    EXPECT_LE(alarms, 6) << "sigma " << sigma;
  }
}

// Skewed noise of unequal strength a side is the hard case for t (a seed that lacks the rare bright values
// looks surer than it is): single alarms come, but the acceptance threshold of `validate` must hold.
TEST(Statistics, UnequalHeavyTailsPassTheThreshold) {
  for (uint32_t run = 0; run < 20; ++run) {
    const BinTest test = test_bins(render(8, {0.8}, 2 * run), render(8, {0.2}, 2 * run + 1), all_pixels());
    EXPECT_GE(test.accepted_share, 0.995);
  }
}

TEST(Statistics, PValuesAreUniformForTameNoise) {
  ErrorFloor none{0, 0};
  double share = 0;
  for (uint32_t run = 0; run < 20; ++run)
    share += test_bins(render(8, {0.2}, 2 * run), render(8, {0.2}, 2 * run + 1), all_pixels(), 3, 0.01, none)
                 .below_5_percent /
             20;
  EXPECT_NEAR(share, 0.05, 0.008);
}

TEST(Statistics, BiasOfOneRegionIsFound) {
  const ImageStack ours = render(8, {0.05, 1.005}, 1), cycles = render(8, {0.05}, 2);
  const RegionRatio left = compare_region("left", ours, cycles, left_half());
  EXPECT_GT(left.total.low, 1.003);
  EXPECT_LT(left.total.high, 1.007);
  std::vector<float> right = left_half();
  for (float& weight : right) weight = 1 - weight;
  const RegionRatio other = compare_region("right", ours, cycles, right);
  EXPECT_GT(other.total.low, 0.997);
  EXPECT_LT(other.total.high, 1.003);
}

TEST(Statistics, IntervalHoldsTheTruthAsOftenAsItSays) {
  int misses = 0;
  for (uint32_t run = 0; run < 300; ++run) {
    const RegionRatio left =
        compare_region("left", render(8, {0.5, 1.01}, 2 * run), render(8, {0.3}, 2 * run + 1), left_half());
    misses += left.total.low > 1.01 || left.total.high < 1.01;
  }
  EXPECT_LE(misses, 15 + 15);  // 5 % expected; 30 of 300 is 4 standard deviations away
  EXPECT_GE(misses, 2);
}

TEST(Statistics, ShiftIsFound) {
  Noise shifted{0.1};
  shifted.shift_px = 5;
  const BinTest test = test_bins(render(8, shifted, 1), render(8, {0.1}, 2), all_pixels());
  EXPECT_LT(test.accepted_share, 0.7);
}

TEST(Statistics, EqualNoiselessImagesAreAccepted) {
  const BinTest test = test_bins(render(4, {0}, 1), render(4, {0}, 2), all_pixels());
  EXPECT_EQ(test.accepted, test.bins);
  const RegionRatio all = compare_region("all", render(4, {0}, 1), render(4, {0}, 2), left_half());
  EXPECT_EQ(all.total.value, 1);
  EXPECT_NEAR(all.total.high - all.total.low, 0, 1e-6);
}

TEST(Statistics, EmptyAndBlackRegions) {
  const ImageStack black(4, Image(kSize, kSize, 3));
  const RegionRatio region = compare_region("black", black, black, left_half());
  EXPECT_EQ(region.total.value, 1);
  const BinTest none = test_bins(black, black, std::vector<uint8_t>(kSize * kSize, 0));
  EXPECT_EQ(none.bins, 0u);
  EXPECT_EQ(none.accepted_share, 1);
  const BinTest dark = test_bins(black, black, all_pixels());
  EXPECT_EQ(dark.accepted, dark.bins);
}

TEST(Statistics, BandIsOnePixelEachSideOfTheOutline) {
  Image coverage(9, 9, 1);
  for (int y = 2; y < 7; ++y)
    for (int x = 2; x < 7; ++x) coverage.pixel(x, y)[0] = 1;
  const PixelSets sets = pixel_sets(coverage, Image(9, 9, 4));
  const auto at = [](const std::vector<uint8_t>& set, int x, int y) { return int{set[y * 9 + x]}; };
  EXPECT_EQ(at(sets.band, 1, 4), 1);
  EXPECT_EQ(at(sets.band, 2, 4), 1);
  EXPECT_EQ(at(sets.band, 3, 4), 0);
  EXPECT_EQ(at(sets.inside, 3, 4), 1);
  EXPECT_EQ(at(sets.inside, 2, 4), 0);
  EXPECT_EQ(at(sets.foreground, 2, 4), 1);
  EXPECT_EQ(at(sets.band, 0, 4), 0);
}

TEST(Statistics, RelativeDifferenceAndVariance) {
  const ImageStack a = render(64, {0.1, 1.1}, 1), b = render(64, {0.1}, 2);
  const Moments moments_a = moments_of(a), moments_b = moments_of(b);
  const Image difference = relative_difference(moments_a.mean, moments_b.mean, all_pixels());
  EXPECT_NEAR(difference.pixel(10, 30)[0], 0.1, 0.02);
  EXPECT_NEAR(difference.pixel(50, 30)[0], 0.0, 0.02);
  // Variance of the log-normal factor is exp(sigma^2) - 1, and the truth's mean square scales it.
  double square = 0;
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x)
      for (int c = 0; c < 3; ++c) square += truth(x, y, c) * truth(x, y, c) / (3.0 * kSize * kSize);
  EXPECT_NEAR(mean_variance(moments_b, all_pixels()) / (square * std::expm1(0.01)), 1, 0.03);
}

}  // namespace
}  // namespace ohb
