// Maps at a picture's size from those at the networks'.
#include "learner/upsample.h"

#include <gtest/gtest.h>

#include "learner/data.h"
#include "learner/estimate.h"
#include "learner/task.h"
#include "test_samples.h"

namespace ohb {
using namespace learner;
namespace {

using torch::Tensor;

constexpr int64_t kLarge_px = 128, kSmall_px = 32;

/// A disc of stripes and blotches of all colours, (1, 4, side, side).
Tensor striped_input() {
  const Tensor x = torch::arange(kLarge_px).view({1, 1, 1, -1}).to(torch::kFloat),
               y = torch::arange(kLarge_px).view({1, 1, -1, 1}).to(torch::kFloat);
  const Tensor mask = ((x - 63.5).square() + (y - 63.5).square() < 55.0 * 55.0).to(torch::kFloat);
  const Tensor srgb = torch::cat({0.5 + 0.3 * (x / 3).sin() + 0 * y, 0.5 + 0.3 * (y / 2.5).cos() + 0 * x,
                                  0.5 + 0.3 * ((x + y) / 5).sin()},
                                 1);
  return network_input(srgb * mask, mask);
}

Tensor srgb_of_input(const Tensor& input) {
  return (input.slice(1, 0, 3) + 1) / 2;
}
Tensor mask_of_input(const Tensor& input) {
  return (input.slice(1, 3, 4) + 1) / 2;
}

/// Ten channels: geometry of one value, then six different linear functions of the colours.
Tensor linear_output(const Tensor& input) {
  const Tensor c = srgb_of_input(input) / mask_of_input(input).clamp_min(1e-3);
  std::vector<Tensor> channels = {torch::full_like(c.slice(1, 0, 1), 0.25).expand({1, 4, -1, -1})};
  for (int i = 0; i < 6; ++i)
    channels.push_back(0.1 * i * c.slice(1, 0, 1) + (0.5 - 0.05 * i) * c.slice(1, 1, 2) +
                       0.2 * c.slice(1, 2, 3));
  return torch::cat(channels, 1);
}

// What the filter is made for: a linear function of the small picture's colours is that function of the large
// one's, however fine the pattern. Interpolation alone is far off.
TEST(Upsampling, LinearFunctionsOfTheColoursComeBack) {
  const Tensor input = striped_input(), small = averaged_input(input, kSmall_px);
  const Tensor output = output_at_size_of(input, linear_output(small), small);
  const Tensor inside = mask_of_input(input).expand({1, 10, -1, -1}) > 0;
  const Tensor error = (output - linear_output(input)).abs().masked_select(inside);
  EXPECT_LT(error.max().item<double>(), 0.02);
  EXPECT_LT(error.mean().item<double>(), 0.002);
  const Tensor plain = torch::upsample_bilinear2d(linear_output(small), {kLarge_px, kLarge_px}, false);
  EXPECT_GT((plain - linear_output(input)).abs().masked_select(inside).mean().item<double>(), 0.01);
}

// Where it has nothing to go by: a picture of one colour, or of noise, leaves what is constant constant, and
// everything in its range.
TEST(Upsampling, StaysInRangeWhereThePictureSaysNothing) {
  torch::manual_seed(5);
  const Tensor mask = mask_of_input(striped_input());
  for (const Tensor& srgb :
       {torch::full({1, 3, kLarge_px, kLarge_px}, 0.4), torch::zeros({1, 3, kLarge_px, kLarge_px}),
        torch::rand({1, 3, kLarge_px, kLarge_px})}) {
    const Tensor input = network_input(srgb * mask, mask), small = averaged_input(input, kSmall_px);
    const Tensor inside = mask.expand({1, 10, -1, -1}) > 0;
    const Tensor constant = output_at_size_of(input, torch::full({1, 10, kSmall_px, kSmall_px}, 0.7), small);
    EXPECT_TRUE(torch::allclose(constant.masked_select(inside), torch::tensor(0.7f), 0, 2e-3));
    const Tensor any = output_at_size_of(input, torch::rand({1, 10, kSmall_px, kSmall_px}), small);
    EXPECT_TRUE(torch::isfinite(any).all().item<bool>());
    EXPECT_GE(any.min().item<double>(), 0);
    EXPECT_LE(any.max().item<double>(), 1);
  }
}

// The background's values, whatever they are, do not come in.
TEST(Upsampling, ForgetsTheBackground) {
  const Tensor input = striped_input(), small = averaged_input(input, kSmall_px);
  const Tensor output = linear_output(small), outside = (mask_of_input(small) == 0).expand({1, 10, -1, -1});
  const Tensor inside = mask_of_input(input).expand({1, 10, -1, -1}) > 0;
  const Tensor once = output_at_size_of(input, output, small);
  const Tensor other = output_at_size_of(input, torch::where(outside, 1 - output, output), small);
  EXPECT_TRUE(torch::allclose(once.masked_select(inside), other.masked_select(inside), 0, 1e-5));
}

// An independent way to the small input: the sample's radiance, averaged before it becomes a photograph.
TEST(Upsampling, AveragedInputsAreThoseOfSmallSamples) {
  const Sample sample = ball_sample(64, "ada", 0);
  const Tensor small = example_of(sample, "f", 0, 16).input;
  const Tensor averaged = averaged_input(example_of(sample, "f", 0, 64).input, 16);
  // What is brighter than the photograph's white is cut before the average in one, after it in the other.
  const Tensor unclipped = (small.slice(1, 0, 3).amax(1, true) < 0.9).expand({1, 4, -1, -1});
  EXPECT_GT(unclipped.sum().item<int>(), 100);
  EXPECT_LT((small - averaged).abs().masked_select(unclipped).max().item<double>(), 0.06);
  EXPECT_TRUE(torch::allclose(small.slice(1, 3, 4), averaged.slice(1, 3, 4), 0, 1e-5));
}

TEST(NaturalSize, IsThePhotosOwnWithinBounds) {
  EXPECT_EQ(natural_size({0, 0, 700}, 128), 704);
  EXPECT_EQ(natural_size({0, 0, 5000}, 128), 1024);
  EXPECT_EQ(natural_size({0, 0, 50}, 128), 128);
  EXPECT_EQ(natural_size({0, 0, 5000}, 2048), 2048);
}

}  // namespace
}  // namespace ohb
