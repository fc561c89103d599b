// Other colours for the same person.
#include "learner/recolour.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "dataset/model/colour.h"
#include "learner/hash.h"

namespace ohb {
using namespace learner;
namespace {

using torch::Tensor;

constexpr int kSize = 32;

Tensor noise(int64_t channels, double low, double high, uint64_t seed) {
  auto generator = at::detail::createCPUGenerator(seed);
  return torch::rand({1, channels, kSize, kSize}, generator, torch::kFloat) * (high - low) + low;
}

/// A picture that is albedo times light, exposed so that nothing clips; the left half is skin, the right half
/// rough and then smooth cloth.
Example lit_example(const Tensor& light) {
  Example e;
  e.mask = torch::ones({1, 1, kSize, kSize});
  e.truth.diffuse = noise(3, 0.05, 0.4, 1);
  e.truth.sss = torch::zeros({1, 1, kSize, kSize});
  e.truth.sss.slice(3, 0, kSize / 2).fill_(0.08);
  e.truth.roughness = torch::full({1, 1, kSize, kSize}, 0.85);
  e.truth.roughness.slice(3, 3 * kSize / 4, kSize).fill_(0.25);
  const Tensor linear = e.truth.diffuse * light;
  Tensor encoded = linear.clone();
  for (int64_t i = 0; i < encoded.numel(); ++i)
    encoded.data_ptr<float>()[i] = linear_to_srgb(linear.contiguous().data_ptr<float>()[i]);
  e.input = torch::cat({encoded * 2 - 1, torch::ones({1, 1, kSize, kSize})}, 1);
  return e;
}

Tensor linear_picture(const Example& e) {
  Tensor picture = ((e.input.slice(1, 0, 3) + 1) / 2).contiguous();
  for (int64_t i = 0; i < picture.numel(); ++i)
    picture.data_ptr<float>()[i] = srgb_to_linear(picture.data_ptr<float>()[i]);
  return picture;
}

TEST(Recolour, KeepsTheLight) {
  const Tensor light = noise(1, 0.3, 1.0, 2);
  for (uint64_t key = 1; key <= 40; ++key) {
    Example e = lit_example(light);
    recolour(e, key);
    // Picture over albedo is the light times one exposure, wherever nothing clips.
    const Tensor picture = linear_picture(e);
    const Tensor kept = picture < 0.99;
    const Tensor exposure = (picture / (e.truth.diffuse * light)).masked_select(kept);
    EXPECT_LT((exposure.max() / exposure.min()).item<float>(), 1.01f) << key;
    // Exposed as photographs are.
    const Tensor largest = picture.amax(1).flatten();
    const double above = (largest > kExposedLevel * 1.001).to(torch::kDouble).mean().item<double>();
    EXPECT_NEAR(above, 1 - kExposedPercentile, 3.0 / (kSize * kSize)) << key;
    EXPECT_GE(e.truth.diffuse.min().item<float>(), 0);
    EXPECT_LE(e.truth.diffuse.max().item<float>(), 0.9501f);
  }
}

TEST(Recolour, ChangesClothAndHardlyTheHueOfSkin) {
  const Tensor light = torch::ones({1, 1, kSize, kSize});
  const Example before = lit_example(light);
  const auto hue_change = [&](const Tensor& a, const Tensor& b) {
    return (a / a.sum(1, true) - b / b.sum(1, true)).abs().mean().item<double>();
  };
  double skin = 0, cloth = 0, between_cloths = 0;
  for (uint64_t key = 1; key <= 40; ++key) {
    Example e = lit_example(light);
    recolour(e, key);
    const auto part = [&](const Tensor& t, int64_t from, int64_t to) { return t.slice(3, from, to); };
    const Tensor &a = e.truth.diffuse, &b = before.truth.diffuse;
    skin += hue_change(part(a, 0, 16), part(b, 0, 16));
    cloth += hue_change(part(a, 16, 32), part(b, 16, 32));
    const auto gain = [&](int64_t from, int64_t to) {
      return part(a, from, to).sum({0, 2, 3}) / part(b, from, to).sum({0, 2, 3});
    };
    between_cloths += (gain(16, 24).log() - gain(24, 32).log()).abs().mean().item<double>();
    // All that the labels say stays.
    EXPECT_TRUE(e.truth.roughness.equal(before.truth.roughness));
    EXPECT_TRUE(e.truth.sss.equal(before.truth.sss));
    EXPECT_TRUE(e.input.slice(1, 3, 4).equal(before.input.slice(1, 3, 4)));
  }
  EXPECT_LT(skin / 40, 0.03);
  EXPECT_GT(cloth / 40, 0.1);
  EXPECT_GT(between_cloths / 40, 0.3) << "rough and smooth cloth change differently";
}

TEST(Recolour, IsAFunctionOfItsKeyAndStandsBlackAndEmptyPictures) {
  const Tensor light = noise(1, 0.3, 1.0, 3);
  Example a = lit_example(light), b = lit_example(light), c = lit_example(light);
  recolour(a, 7);
  recolour(b, 7);
  recolour(c, 8);
  EXPECT_TRUE(a.input.equal(b.input) && a.truth.diffuse.equal(b.truth.diffuse));
  EXPECT_FALSE(a.truth.diffuse.equal(c.truth.diffuse));
  Example black = lit_example(light * 0);
  black.truth.diffuse.zero_();
  black.mask.zero_();
  black.truth.sss.zero_();
  recolour(black, 7);
  EXPECT_TRUE(black.input.isfinite().all().item<bool>());
  EXPECT_TRUE(black.truth.diffuse.isfinite().all().item<bool>());
}

}  // namespace
}  // namespace ohb
