// Where and how much more is rendered.
#include "renderer/validation/focus.h"

#include <gtest/gtest.h>

#include <cmath>

namespace ohb {
using namespace renderer;
using namespace validation;
namespace {

TEST(Focus, BoxesHoldAllWeightsAndStayApart) {
  constexpr int kWidth = 100, kHeight = 60;
  std::vector<float> weights(kWidth * kHeight, 0.0f);
  const auto fill = [&](int x0, int y0, int x1, int y1) {
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x) weights[y * kWidth + x] = 0.5f;
  };
  fill(3, 4, 20, 11);
  fill(90, 50, 100, 60);
  fill(40, 0, 42, 60);
  const std::vector<PixelBox> boxes = boxes_around(weights, kWidth, kHeight);
  ASSERT_EQ(boxes.size(), 3u);
  double covered = 0, area = 0;
  for (const PixelBox& box : boxes) {
    area += (box.x1 - box.x0) * (box.y1 - box.y0);
    for (int y = box.y0; y < box.y1; ++y)
      for (int x = box.x0; x < box.x1; ++x) covered += weights[y * kWidth + x];
  }
  EXPECT_DOUBLE_EQ(covered, 0.5 * (17 * 7 + 10 * 10 + 2 * 60));
  EXPECT_DOUBLE_EQ(area, 17 * 7 + 10 * 10 + 2 * 60);
}

TEST(Focus, LShapeIsOneBox) {
  std::vector<float> weights(64 * 64, 0.0f);
  for (int i = 0; i < 64; ++i) weights[i * 64] = weights[63 * 64 + i] = 1;
  const std::vector<PixelBox> boxes = boxes_around(weights, 64, 64);
  ASSERT_EQ(boxes.size(), 1u);
  EXPECT_EQ(boxes[0].x1, 64);
  EXPECT_TRUE(boxes_around(std::vector<float>(64, 0.0f), 8, 8).empty());
}

TEST(Focus, NarrowIntervalsAskForNoMoreWork) {
  EXPECT_FALSE(more_work({1, 0.9999, 1.0001}, {8, 128, 128}, 0.001, 100, 8192));
}

TEST(Focus, WorkIsSpreadOverSeedsUpToItsLimit) {
  const auto few = more_work({1, 0.997, 1.003}, {8, 128, 128}, 0.001, 100, 8192);
  ASSERT_TRUE(few);
  EXPECT_EQ(few->seeds, 8);
  const auto many = more_work({1, 0.9, 1.1}, {8, 128, 128}, 0.001, 100, 8192);
  ASSERT_TRUE(many);
  EXPECT_EQ(many->seeds, 13);  // of 100 x 128 x 8 paths
  EXPECT_NEAR(many->seeds * many->cycles_spp, 102400, 13);
  EXPECT_LE(many->cycles_spp, 8192);
}

/// The half-width that the work leaves, by the noise that the first interval tells of each side.
double half_width_after(const Interval& first, const SidesWork& before, const SidesWork& after) {
  const auto paths = [](int spp, int seeds) { return static_cast<double>(spp) * seeds; };
  const double ours = paths(before.our_spp, before.seeds) / paths(after.our_spp, after.seeds);
  const double cycles = paths(before.cycles_spp, before.seeds) / paths(after.cycles_spp, after.seeds);
  return 0.5 * (first.high - first.low) * std::sqrt(first.share_a * ours + (1 - first.share_a) * cycles);
}

TEST(Focus, WorkReachesTheTargetWhicheverSideIsNoisy) {
  for (const double share_a : {0.0, 0.01, 0.1, 0.5, 0.9, 1.0})
    for (const int our_spp : {64, 128}) {
      const Interval ratio{1, 0.99, 1.01, share_a};
      const SidesWork first{8, our_spp, 128};
      const auto work = more_work(ratio, first, 0.002, 1e4, 8192);
      ASSERT_TRUE(work);
      EXPECT_NEAR(half_width_after(ratio, first, *work), 0.002, 2e-5) << share_a << " " << our_spp;
    }
}

TEST(Focus, WhereCyclesMayNotGetWhatItNeedsOursStillDoes) {
  const SidesWork first{8, 64, 64};
  const auto work = more_work({1, 0.99, 1.01, 0.2}, first, 0.001, 8, 8192);
  ASSERT_TRUE(work);
  EXPECT_EQ(work->cycles_spp, 512);
  EXPECT_EQ(work->our_spp, 512);
  const auto quiet = more_work({1, 0.997, 1.003, 0.1}, first, 0.001, 8, 8192);
  ASSERT_TRUE(quiet);
  EXPECT_EQ(quiet->cycles_spp, 512);
  EXPECT_LT(quiet->our_spp, 256);
  EXPECT_GT(quiet->our_spp, 128);
}

TEST(Focus, TheQuieterSideGetsFewerPaths) {
  const auto work = more_work({1, 0.99, 1.01, 0.1}, {8, 128, 128}, 0.001, 1e4, 8192);
  ASSERT_TRUE(work);
  EXPECT_NEAR(static_cast<double>(work->our_spp) / work->cycles_spp, std::sqrt(0.1 / 0.9 / 2), 0.01);
  const auto equal = more_work({1, 0.99, 1.01, 0.999}, {8, 128, 128}, 0.001, 1e4, 8192);
  ASSERT_TRUE(equal);
  EXPECT_EQ(equal->our_spp, equal->cycles_spp);
}

}  // namespace
}  // namespace ohb
