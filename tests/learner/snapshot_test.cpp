// Pictures as cameras and matting programs spoil them.
#include "learner/snapshot.h"

#include <gtest/gtest.h>

#include "learner/task.h"

namespace ohb {
using namespace learner;
namespace {

using torch::Tensor;

constexpr int kSize = 32;

/// A disc of one grey that leaves room to brighten, with a soft edge.
Example grey_disc(float linear) {
  const Tensor x = torch::arange(kSize).view({1, kSize}) - 15.5,
               y = torch::arange(kSize).view({kSize, 1}) - 15.5;
  Example e;
  e.mask = ((11 - (x * x + y * y).sqrt()).clamp(0, 1)).view({1, 1, kSize, kSize});
  e.truth.diffuse = torch::full({1, 3, kSize, kSize}, linear);
  e.input = network_input(srgb_of(e.truth.diffuse) * e.mask, e.mask);
  return e;
}

Tensor colours(const Example& e) {
  return (e.input.slice(1, 0, 3) + 1) / 2;
}
Tensor matte(const Example& e) {
  return (e.input.slice(1, 3, 4) + 1) / 2;
}

TEST(Snapshot, IsAFunctionOfItsKeyAndLeavesTheTruth) {
  Example a = grey_disc(0.3f), b = grey_disc(0.3f), c = grey_disc(0.3f);
  take_snapshot(a, 1);
  take_snapshot(b, 1);
  take_snapshot(c, 2);
  EXPECT_TRUE(torch::equal(a.input, b.input));
  EXPECT_FALSE(torch::equal(a.input, c.input));
  EXPECT_TRUE(torch::equal(a.truth.diffuse, grey_disc(0.3f).truth.diffuse));
  EXPECT_TRUE(torch::equal(a.mask, grey_disc(0.3f).mask)) << "the loss goes by the true mask";
}

TEST(Snapshot, StaysAPictureTimesItsMatte) {
  for (uint64_t key = 1; key <= 60; ++key) {
    Example e = grey_disc(0.8f);
    take_snapshot(e, key);
    EXPECT_GE(e.input.min().item<float>(), -1);
    EXPECT_LE(e.input.max().item<float>(), 1);
    EXPECT_FALSE(((colours(e) > 1e-6) & (matte(e) == 0)).any().item<bool>()) << key;
  }
}

TEST(Snapshot, LevelsAndMattesVaryAsFarAsItSays) {
  double lowest = 1, highest = 0, smallest = 1e9, largest = 0;
  const double area = grey_disc(0.3f).mask.sum().item<double>();
  for (uint64_t key = 1; key <= 200; ++key) {
    Example e = grey_disc(0.3f);
    take_snapshot(e, key);
    const double level = colours(e).slice(2, 12, 20).slice(3, 12, 20).mean().item<double>();
    lowest = std::min(lowest, level);
    highest = std::max(highest, level);
    const double covered = matte(e).sum().item<double>() / area;
    smallest = std::min(smallest, covered);
    largest = std::max(largest, covered);
  }
  // Half a stop either way of linear 0.3 (sRGB 0.58) is 0.50 to 0.68; balance, gamma and contrast add some.
  EXPECT_LT(lowest, 0.5);
  EXPECT_GT(lowest, 0.3);
  EXPECT_GT(highest, 0.68);
  EXPECT_LT(highest, 0.85);
  EXPECT_LT(smallest, 0.86) << "a pixel less all around 10.5: 0.82";
  EXPECT_GT(largest, 1.14);
}

}  // namespace
}  // namespace ohb
