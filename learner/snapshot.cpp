#include "learner/snapshot.h"

#include <ATen/CPUGeneratorImpl.h>

#include <cmath>

#include "learner/hash.h"
#include "learner/task.h"

namespace ohb::learner {
namespace {

using torch::Tensor;

constexpr double kStops = 0.5, kBalance = 0.12, kGamma = 0.15, kContrast = 0.4, kNoise = 0.03;
constexpr double kBlurred = 0.3, kWrongMatte = 0.4;  // shares of the pictures

/// Mean of 3 x 3 pixels; what is beyond the frame counts for nothing.
Tensor blurred(const Tensor& x) {
  return torch::avg_pool2d(x, 3, 1, 1, false, false);
}

/// Colours of the foreground, linear, from an input that was multiplied by its mask.
Tensor colours_of(const Tensor& input, const Tensor& mask) {
  const Tensor srgb = ((input.slice(1, 0, 3) + 1) / 2) / mask.clamp_min(1e-3);
  return linear_of(srgb.clamp(0, 1)) * (mask > 0);
}

/// The matte as programs get it wrong.
Tensor wrong_matte(const Tensor& mask, double kind) {
  if (kind < 1 / 3.0) return -torch::max_pool2d(-mask, 3, 1, 1);
  if (kind < 2 / 3.0) return torch::max_pool2d(mask, 3, 1, 1);
  return blurred(mask);
}

}  // namespace

void take_snapshot(Example& e, uint64_t key) {
  uint64_t drawn = 0;
  const auto between = [&](double low, double high) { return low + (high - low) * uniform_of(key, drawn++); };
  Tensor linear = colours_of(e.input, e.mask);
  const double exposure = std::exp2(between(-kStops, kStops));
  for (int c = 0; c < 3; ++c) linear.select(1, c).mul_(exposure * std::exp(between(-kBalance, kBalance)));
  Tensor srgb = srgb_of(linear);
  srgb = srgb.pow(std::exp(between(-kGamma, kGamma)));
  srgb = torch::lerp(srgb, srgb * srgb * (3 - 2 * srgb), between(0, kContrast));
  Tensor mask = e.mask;
  if (between(0, 1) < kBlurred) {
    // Weighted by the mask, so that no dark rim comes in.
    srgb = blurred(srgb * mask) / blurred(mask).clamp_min(1e-3);
  }
  auto generator = at::detail::createCPUGenerator(key);
  srgb = srgb + between(0, kNoise) * torch::randn(srgb.sizes(), generator, srgb.options());
  const double kind = between(0, 1);
  if (between(0, 1) < kWrongMatte) mask = wrong_matte(mask, kind);
  e.input = network_input(srgb.clamp(0, 1) * mask, mask).contiguous();
}

}  // namespace ohb::learner
