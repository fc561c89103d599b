// Where and how much more is rendered.
#include "renderer/validation/focus.h"

#include <gtest/gtest.h>

namespace ohb {
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

TEST(Focus, WorkGrowsWithTheSquareAndIsSpreadOverSeeds) {
  EXPECT_NEAR(work_factor({1, 0.99, 1.01}, 0.001), 100, 1e-9);
  EXPECT_DOUBLE_EQ(work_factor({1, 0.9999, 1.0001}, 0.001), 1);
  const Work few = spread_work(10, 128, 8, 8192);
  EXPECT_EQ(few.seeds, 8);
  EXPECT_EQ(few.spp, 1280);
  const Work many = spread_work(100, 128, 8, 8192);
  EXPECT_EQ(many.seeds, 13);
  EXPECT_GE(many.seeds * many.spp, 102400);
  EXPECT_LE(many.spp, 8192);
}

}  // namespace
}  // namespace ohb
