#include "learner/recolour.h"

#include <algorithm>
#include <cmath>

#include "learner/hash.h"

namespace ohb::learner {
namespace {

using torch::Tensor;

constexpr double kLargestAlbedo = 0.95;
constexpr double kDarkest = 1e-4;  // below this an albedo has no colour to scale

Tensor decoded(const Tensor& srgb) {
  return torch::where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055).pow(2.4));
}

Tensor encoded(const Tensor& linear) {
  return torch::where(linear <= 0.0031308, linear * 12.92,
                      1.055 * linear.clamp_min(0.0031308).pow(1 / 2.4) - 0.055);
}

}  // namespace

void recolour(Example& e, uint64_t key) {
  uint64_t drawn = 0;
  const auto between = [&](double low, double high) { return low + (high - low) * uniform_of(key, drawn++); };
  static constexpr int64_t kOrders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  const auto& order = kOrders[static_cast<int>(between(0, 6)) % 6];
  const Tensor channels = torch::tensor({order[0], order[1], order[2]}, torch::kLong);
  const Tensor scattering = e.truth.sss / e.truth.sss.max().clamp_min(1e-6);
  const Tensor roughness = (e.truth.roughness - 0.5) / 0.35;

  const double skin_lightness = between(-0.9, 0.4);
  Tensor gain = torch::empty_like(e.truth.diffuse), skin_gain = torch::empty_like(e.truth.diffuse);
  for (int c = 0; c < 3; ++c) {
    skin_gain.select(1, c).fill_(std::exp(skin_lightness + between(-0.1, 0.1)));
    const double level = between(-1.2, 0.9), slope = between(-0.8, 0.8);
    gain.select(1, c).copy_((level + slope * roughness.select(1, 0)).exp());
  }
  const auto changed = [&](const Tensor& colour) {
    return (1 - scattering) * gain * colour.index_select(1, channels) + scattering * skin_gain * colour;
  };
  // What would reflect more than is plausible is darkened as a whole, which keeps its hue and texture.
  const Tensor albedo = changed(e.truth.diffuse);
  const Tensor limit = (kLargestAlbedo / albedo.amax(1, true).clamp_min(kDarkest)).clamp_max(1);
  e.truth.diffuse = albedo * limit;

  const Tensor mask = e.mask > 0.5;
  Tensor light = changed(decoded((e.input.slice(1, 0, 3) + 1) / 2)) * limit;
  const Tensor brightest = light.amax(1, true).masked_select(mask);
  if (brightest.numel() > 0) {
    const auto count = static_cast<double>(brightest.numel());
    const int64_t rank = std::min(brightest.numel() - 1, static_cast<int64_t>(kExposedPercentile * count));
    const double level = std::get<0>(brightest.kthvalue(rank + 1)).item<double>();
    if (level > 0) light = light * (kExposedLevel / level);
  }
  e.input = torch::cat({encoded(light.clamp(0, 1)) * 2 - 1, e.input.slice(1, 3, 4)}, 1);
}

}  // namespace ohb::learner
