// Windows of samples: averages over any of them, and which are drawn.
#include "learner/window.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "learner/data.h"
#include "test_samples.h"

namespace ohb {
using namespace learner;
namespace {

Image ramp(int side_px) {
  Image image(side_px, side_px, 2);
  for (int y = 0; y < side_px; ++y)
    for (int x = 0; x < side_px; ++x) {
      image.pixel(x, y)[0] = static_cast<float>(x) + 0.5f;
      image.pixel(x, y)[1] = static_cast<float>(y) + 0.5f;
    }
  return image;
}

// The mean of steps of one unit over an interval is that of the straight line but for the two ends' parts:
// at most an eighth off, and exact where the ends fall on pixels.
TEST(Window, AveragesOfARampAreTheMiddles) {
  const Image image = ramp(48);
  for (const Window window : {Window{0, 0, 48}, Window{5, 3, 36}, Window{10, 20, 27}, Window{7, 7, 16}}) {
    const Image out = averaged(image, nullptr, window, 16);
    const double step = window.side_px / 16.0, most = window.side_px % 16 == 0 ? 1e-5 : 0.126;
    for (int y = 0; y < 16; ++y)
      for (int x = 0; x < 16; ++x) {
        EXPECT_NEAR(out.pixel(x, y)[0], window.left_px + (x + 0.5) * step, most);
        EXPECT_NEAR(out.pixel(x, y)[1], window.top_px + (y + 0.5) * step, most);
      }
  }
}

// Nothing is lost or counted twice: the mean of the averages is that of the window.
TEST(Window, AveragesKeepTheMean) {
  Image image(40, 40, 1);
  for (size_t i = 0; i < image.values.size(); ++i) image.values[i] = static_cast<float>((i * 7919) % 101);
  const Window window{2, 6, 31};
  const Image out = averaged(image, nullptr, window, 16);
  double mean = 0, wanted = 0;
  for (const float v : out.values) mean += v / (16 * 16);
  for (int y = 6; y < 37; ++y)
    for (int x = 2; x < 33; ++x) wanted += *image.pixel(x, y) / (31.0 * 31.0);
  EXPECT_NEAR(mean, wanted, 1e-4);
}

TEST(Window, WhatWeighsNothingIsLeftOut) {
  Image image = ramp(32), weight(32, 32, 1);
  for (int y = 0; y < 32; ++y) weight.pixel(9, y)[0] = 1;
  const Image out = averaged(image, &weight, {0, 0, 24}, 16);
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 16; ++x)
      EXPECT_NEAR(out.pixel(x, y)[0], x == 6 ? 9.5f : 0.0f, 1e-5) << x;  // 9 to 10.5 of the 24
}

TEST(Window, DrawnOnesLieInTheFrameAndShowSomebody) {
  const Sample sample = ball_sample(64, "ada", 0);
  int whole = 0, smallest = 64, largest = 0;
  for (uint64_t key = 1; key <= 400; ++key) {
    const Window w = drawn_window(sample.mask, 32, key), again = drawn_window(sample.mask, 32, key);
    EXPECT_EQ(w.left_px, again.left_px);
    EXPECT_EQ(w.side_px, again.side_px);
    if (w.side_px == 64) {
      ++whole;
      continue;
    }
    smallest = std::min(smallest, w.side_px);
    largest = std::max(largest, w.side_px);
    EXPECT_GE(w.side_px, 32);
    EXPECT_TRUE(w.left_px >= 0 && w.top_px >= 0 && w.left_px + w.side_px <= 64 && w.top_px + w.side_px <= 64);
    double covered = 0;
    for (int y = w.top_px; y < w.top_px + w.side_px; ++y)
      for (int x = w.left_px; x < w.left_px + w.side_px; ++x) covered += *sample.mask.pixel(x, y);
    EXPECT_GE(covered / (w.side_px * w.side_px), 0.1);
  }
  // Half of 400 draws; 4.5 deviations of a fair coin are 45.
  EXPECT_NEAR(whole, 200, 45);
  EXPECT_LT(smallest, 35);
  EXPECT_GT(largest, 58);
  Image nobody(64, 64, 1);
  EXPECT_EQ(drawn_window(nobody, 32, 3).side_px, 64);
}

// A window that is the middle half of the frame is the picture of a camera with half the frame: the same
// normals and albedo, displacement twice as large in half frames, the same in cm.
TEST(Window, AnExampleOfAPartIsOneOfASmallerFrame) {
  const Sample sample = ball_sample(64, "ada", 0);
  const Example part = example_of(sample, "f", 0, 32, Window{16, 16, 32});
  EXPECT_EQ(part.half_frame_cm, 50);
  for (const auto& [x, y] : {std::pair{3, 7}, {16, 16}, {30, 20}}) {
    EXPECT_NEAR(part.truth.displacement[0][0][y][x].item<float>() * 50,
                sample.displacement.pixel(16 + x, 16 + y)[0], 1e-3);
    EXPECT_NEAR(part.truth.normal[0][1][y][x].item<float>(), sample.normal.pixel(16 + x, 16 + y)[1], 1e-5);
    EXPECT_EQ(part.truth.diffuse[0][2][y][x].item<float>(), sample.diffuse.pixel(16 + x, 16 + y)[2]);
  }
}

}  // namespace
}  // namespace ohb
