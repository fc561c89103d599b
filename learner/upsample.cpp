#include "learner/upsample.h"

#include "learner/data.h"
#include "learner/task.h"

namespace ohb::learner {
namespace {

using torch::Tensor;
namespace F = torch::nn::functional;

constexpr double kTiny = 1e-6;

// Chosen on generated people at four times the networks' size: radius 1 to 3, ridge 1e-5 to 1e-2.
constexpr int64_t kRadius_px = 3;
constexpr double kRidge = 1e-4;
constexpr int64_t kGeometryChannels = 4;

Tensor mask_of_input(const Tensor& input) {
  return (input.slice(1, 3, 4) + 1) / 2;
}

/// sRGB of the foreground; 0 outside.
Tensor colours_of(const Tensor& input, const Tensor& mask) {
  return ((input.slice(1, 0, 3) + 1) / 2 / mask.clamp_min(1e-3)).clamp(0, 1) * (mask > 0);
}

/// Sums over windows, over the number of their pixels.
Tensor windows(const Tensor& x) {
  return torch::avg_pool2d(x, 2 * kRadius_px + 1, 1, kRadius_px);
}

/// Brings what is known at the size of a small picture to that of a large one, whatever the background holds.
class Enlarger {
 public:
  Enlarger(const Tensor& small_mask, const Tensor& large)
      : small_mask_(small_mask),
        size_px_{large.size(2), large.size(3)},
        weight_(interpolated(small_mask) + kTiny) {}
  Tensor operator()(const Tensor& x) const { return interpolated(x * small_mask_) / weight_; }

 private:
  Tensor interpolated(const Tensor& x) const {
    return F::interpolate(
        x, F::InterpolateFuncOptions().size(size_px_).mode(torch::kBilinear).align_corners(false));
  }
  Tensor small_mask_;
  std::vector<int64_t> size_px_;
  Tensor weight_;
};

/// What the output is in each window of the guide: (B, 3 C, h, w) factors of red, green and blue, and
/// (B, C, h, w) constants.
struct LinearFit {
  Tensor factors, constants;
};

LinearFit fit(const Tensor& output, const Tensor& guide, const Tensor& mask) {
  const int64_t batch = output.size(0), channels = output.size(1), height = output.size(2),
                width = output.size(3);
  const Tensor weight = windows(mask) + kTiny;
  const auto mean = [&](const Tensor& x) { return windows(mask * x) / weight; };
  const Tensor guide_mean = mean(guide), output_mean = mean(output);
  std::vector<Tensor> covariance, variance;
  for (int64_t c = 0; c < 3; ++c) {
    const Tensor one = guide.slice(1, c, c + 1), its_mean = guide_mean.slice(1, c, c + 1);
    covariance.push_back(mean(one * output) - its_mean * output_mean);
    variance.push_back(mean(one * guide) - its_mean * guide_mean);
  }
  // One system of three equations a pixel.
  const auto by_pixel = [](const std::vector<Tensor>& rows) {
    return torch::stack(rows, 1).permute({0, 3, 4, 1, 2});
  };
  const Tensor ridge = kRidge * torch::eye(3, output.options());
  const Tensor factors = torch::linalg_solve(by_pixel(variance) + ridge, by_pixel(covariance))
                             .permute({0, 3, 4, 1, 2});  // (B, 3, C, h, w)
  const Tensor constants = output_mean - (factors * guide_mean.unsqueeze(2)).sum(1);
  return {mean(factors.reshape({batch, 3 * channels, height, width})), mean(constants)};
}

}  // namespace

Tensor averaged_input(const Tensor& input, int64_t size_px) {
  const Tensor mask = mask_of_input(input);
  const Tensor linear = linear_of(colours_of(input, mask)) * mask;
  const Tensor small_mask = torch::adaptive_avg_pool2d(mask, {size_px, size_px});
  const Tensor colours = torch::adaptive_avg_pool2d(linear, {size_px, size_px}) / small_mask.clamp_min(kTiny);
  return network_input(srgb_of(colours) * small_mask, small_mask);
}

Tensor output_at_size_of(const Tensor& input, const Tensor& output, const Tensor& small) {
  const Tensor small_mask = mask_of_input(small), mask = mask_of_input(input);
  const Enlarger enlarged(small_mask, input);
  const Tensor materials = output.slice(1, kGeometryChannels);
  const LinearFit linear = fit(materials, colours_of(small, small_mask), small_mask);
  const Tensor guide = colours_of(input, mask);
  Tensor guided = enlarged(linear.constants);
  const int64_t channels = materials.size(1);
  for (int64_t c = 0; c < 3; ++c)
    guided.addcmul_(enlarged(linear.factors.slice(1, c * channels, (c + 1) * channels)),
                    guide.slice(1, c, c + 1));
  return torch::cat({enlarged(output.slice(1, 0, kGeometryChannels)), guided}, 1).clamp(0, 1);
}

}  // namespace ohb::learner
