#include "learner/stress_cases.h"

#include <ATen/CPUGeneratorImpl.h>

#include <algorithm>
#include <cmath>

#include "learner/task.h"

namespace ohb::learner {
namespace {

using torch::Tensor;
namespace F = torch::nn::functional;

constexpr double kWall = 0.5;  // sRGB
constexpr int kBlock_px = 8;

Tensor on_wall(const Tensor& foreground, const Tensor& mask) {
  return foreground * mask + kWall * (1 - mask);
}

Tensor cut_out(const Tensor& picture, const Tensor& mask) {
  return network_input(picture * mask, mask).contiguous();
}

/// Linear to sRGB as a camera exposes it, `stops` over what training does.
Tensor exposed(const Tensor& linear, const Tensor& mask, double stops) {
  const Tensor brightest = std::get<0>(linear.max(1, true)).masked_select(mask > 0.5);
  const double level = brightest.quantile(kExposedPercentile).item<double>();
  const double exposure = kExposedLevel / std::max(level, 1e-9) * std::exp2(stops);
  return srgb_of((linear * exposure).clamp(0, 1));
}

/// The foreground by `share` of sun, exposed.
Tensor lit(const StressSubject& s, double sun_over_sky_stops = 0, double over_exposure_stops = 0,
           double colour_stops = 0) {
  const double ratio = std::exp2(sun_over_sky_stops);
  Tensor linear = (s.sky + ratio * s.sun) / (1 + ratio);
  linear = linear.nan_to_num(0);
  linear = linear * torch::tensor({std::exp2(colour_stops), 1.0, std::exp2(-colour_stops)}, torch::kFloat)
                        .view({1, 3, 1, 1});
  return exposed(linear, s.example.mask, over_exposure_stops);
}

StressPicture plain(const StressSubject& s, const Tensor& foreground) {
  const Tensor& mask = s.example.mask;
  return {cut_out(on_wall(foreground, mask), mask), mask, s.example.truth, static_cast<int>(mask.size(3))};
}

/// A JPEG's table of that quality; rows of 8 from the lowest frequency.
Tensor quantisation(int quality, bool luma) {
  static const std::vector<double> kLuma = {
      16, 11,  10,  16, 24, 40, 51, 61, 12,  12,  14,  19,  26, 58, 60, 55,  14,  13,  16,  24, 40, 57,
      69, 56,  14,  17, 22, 29, 51, 87, 80,  62,  18,  22,  37, 56, 68, 109, 103, 77,  24,  35, 55, 64,
      81, 104, 113, 92, 49, 64, 78, 87, 103, 121, 120, 101, 72, 92, 95, 98,  112, 100, 103, 99};
  static const std::vector<double> kChroma = {17, 18, 24, 47, 99, 99, 99, 99, 18, 21, 26, 66, 99, 99, 99, 99,
                                              24, 26, 56, 99, 99, 99, 99, 99, 47, 66, 99, 99, 99, 99, 99, 99,
                                              99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99,
                                              99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99};
  const double scale = quality < 50 ? 5000.0 / quality : 200.0 - 2 * quality;
  const Tensor table = torch::tensor(luma ? kLuma : kChroma, torch::kDouble).view({kBlock_px, kBlock_px});
  return ((table * scale + 50) / 100).floor().clamp(1, 255);
}

/// Orthonormal DCT-II of 8 values: rows are frequencies.
Tensor cosines() {
  const Tensor k = torch::arange(kBlock_px, torch::kDouble).unsqueeze(1);
  const Tensor x = torch::arange(kBlock_px, torch::kDouble).unsqueeze(0) + 0.5;
  Tensor basis = (k * x * (M_PI / kBlock_px)).cos() * std::sqrt(2.0 / kBlock_px);
  basis[0] *= std::sqrt(0.5);
  return basis;
}

Tensor luma_and_chroma() {
  return torch::tensor({0.299, 0.587, 0.114, -0.168736, -0.331264, 0.5, 0.5, -0.418688, -0.081312},
                       torch::kDouble)
      .view({3, 3});
}

Tensor enlarged_or_eroded(const Tensor& mask, int pixels) {
  if (pixels == 0) return mask;
  const int64_t window = 2 * std::abs(pixels) + 1, pad = std::abs(pixels);
  return pixels > 0 ? torch::max_pool2d(mask, window, 1, pad)
                    : 1 - torch::max_pool2d(1 - mask, window, 1, pad);
}

/// The square of the person's width or more that shows `share` of the height from the top, scaled to the
/// frame.
Tensor part_of(const Tensor& x, const Tensor& mask, double share) {
  const Tensor covered = (mask[0][0] > 0.5).nonzero();
  const Tensor low = std::get<0>(covered.min(0)), high = std::get<0>(covered.max(0));
  const int64_t top = low[0].item<int64_t>(), height = high[0].item<int64_t>() + 1 - top;
  const int64_t n = mask.size(3), side = std::clamp<int64_t>(std::lround(share * height), 8, n - top);
  const int64_t centre = (low[1].item<int64_t>() + high[1].item<int64_t>() + 1) / 2;
  const int64_t left = std::clamp<int64_t>(centre - side / 2, 0, n - side);
  const Tensor part = x.slice(2, top, top + side).slice(3, left, left + side);
  return F::interpolate(part, F::InterpolateFuncOptions()
                                  .size(std::vector<int64_t>{n, n})
                                  .mode(torch::kBilinear)
                                  .align_corners(false));
}

StressPicture cropped(const StressSubject& s, double share) {
  StressPicture picture = plain(s, lit(s));
  if (share >= 1) return picture;
  const Tensor& mask = s.example.mask;
  picture.input = part_of(picture.input, mask, share).contiguous();
  picture.mask = part_of(mask, mask, share);
  for (const LearnedMap& map : kMaps)
    picture.truth.*map.tensor = part_of(s.example.truth.*map.tensor, mask, share);
  picture.same_pixels = false;
  return picture;
}

StressPicture noisy(const StressSubject& s, double deviation) {
  auto generator = at::detail::createCPUGenerator(s.key);
  const Tensor picture = on_wall(lit(s), s.example.mask);
  const Tensor noise = torch::randn(picture.sizes(), generator, picture.options());
  StressPicture out = plain(s, lit(s));
  out.input = cut_out((picture + deviation * noise).clamp(0, 1), s.example.mask);
  return out;
}

StressPicture compressed(const StressSubject& s, double quality) {
  StressPicture out = plain(s, lit(s));
  if (quality < 100)
    out.input = cut_out(as_jpeg(on_wall(lit(s), s.example.mask), static_cast<int>(quality)), s.example.mask);
  return out;
}

StressPicture wrongly_cut(const StressSubject& s, double pixels) {
  StressPicture out = plain(s, lit(s));
  out.input =
      cut_out(on_wall(lit(s), s.example.mask), enlarged_or_eroded(s.example.mask, static_cast<int>(pixels)));
  return out;
}

StressPicture resized(const StressSubject& s, double factor) {
  StressPicture out = plain(s, lit(s));
  out.network_px = static_cast<int>(std::lround(factor * out.network_px));
  return out;
}

/// Factors at which a size is a multiple of 16. Of larger pictures networks see no more than they were
/// trained at.
std::vector<double> size_factors(int size_px) {
  std::vector<double> factors;
  for (const double factor : {0.25, 0.5, 0.75, 1.0})
    if (std::fmod(factor * size_px, kResolutionStep) == 0) factors.push_back(factor);
  return factors;
}

}  // namespace

Tensor as_jpeg(const Tensor& srgb, int quality) {
  const int64_t rows = srgb.size(2) / kBlock_px, columns = srgb.size(3) / kBlock_px;
  const Tensor matrix = luma_and_chroma(), basis = cosines();
  const Tensor planes = torch::einsum("ij,bjhw->bihw", {matrix, srgb.to(torch::kDouble) * 255}) -
                        torch::tensor({128.0, 0.0, 0.0}, torch::kDouble).view({1, 3, 1, 1});
  const Tensor blocks = planes.view({1, 3, rows, kBlock_px, columns, kBlock_px}).transpose(3, 4);
  const Tensor table =
      torch::stack({quantisation(quality, true), quantisation(quality, false), quantisation(quality, false)})
          .view({1, 3, 1, 1, kBlock_px, kBlock_px});
  const Tensor codes = (basis.matmul(blocks).matmul(basis.t()) / table).round();
  const Tensor decoded = basis.t().matmul(codes * table).matmul(basis);
  const Tensor stored = decoded.transpose(3, 4).reshape(planes.sizes()) +
                        torch::tensor({128.0, 0.0, 0.0}, torch::kDouble).view({1, 3, 1, 1});
  const Tensor rgb = torch::einsum("ij,bjhw->bihw", {matrix.inverse(), stored});
  return (rgb.round() / 255).clamp(0, 1).to(srgb.dtype());
}

std::vector<StressKind> stress_kinds(int size_px) {
  using S = const StressSubject&;
  return {
      {"contrast",
       "sun over sky, stops",
       {-4, -2, 0, 2, 4, 6},
       0,
       [](S s, double stops) { return plain(s, lit(s, stops)); }},
      {"exposure",
       "stops over a good one",
       {-4, -2, 0, 1, 2, 3, 4},
       0,
       [](S s, double stops) { return plain(s, lit(s, 0, stops)); }},
      {"colour",
       "red over green over blue, stops",
       {-1, -0.5, 0, 0.25, 0.5, 1, 1.5},
       0,
       [](S s, double stops) { return plain(s, lit(s, 0, 0, stops)); }},
      {"noise", "deviation, of 1", {0, 0.02, 0.05, 0.1, 0.2}, 0, noisy},
      {"jpeg", "quality", {5, 10, 20, 40, 80, 100}, 100, compressed},
      {"mask", "pixels too large", {-4, -2, -1, 0, 1, 2, 4, 8}, 0, wrongly_cut},
      {"crop", "share of the height in the picture", {0.25, 0.35, 0.5, 0.75, 1}, 1, cropped},
      {"size", "side over that of the samples", size_factors(size_px), 1, resized},
  };
}

}  // namespace ohb::learner
