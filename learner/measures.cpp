#include "learner/measures.h"

#include <algorithm>
#include <cmath>

#include "dataset/model/data_files.h"
#include "dataset/model/map_table.h"
#include "learner/hash.h"
#include "learner/metrics.h"
#include "learner/task.h"

namespace ohb::learner {
namespace {

using torch::Tensor;

constexpr int kWindow_px = 11;
constexpr double kSigma_px = 1.5, kC1 = 1e-4, kC2 = 9e-4;
constexpr int kResamples = 2000;
constexpr double kTail = 0.05;

Measures no_measures() {
  Measures none;
  none.fill(std::nan(""));
  return none;
}

/// Each channel by itself, windows of equal sum, nothing beyond the frame.
Tensor windowed(const Tensor& x) {
  const Tensor at = torch::arange(kWindow_px, torch::kDouble) - kWindow_px / 2;
  const Tensor line = (-at.square() / (2 * kSigma_px * kSigma_px)).exp();
  const Tensor window = (line.unsqueeze(0) * line.unsqueeze(1) / line.sum().square())
                            .expand({x.size(1), 1, kWindow_px, kWindow_px})
                            .contiguous();
  return torch::conv2d(x, window, {}, 1, kWindow_px / 2, 1, x.size(1));
}

/// Degrees, one a pixel of the foreground. By the arc tangent: the arc cosine is blind to small angles.
Tensor normal_angles(const MaterialMaps& a, const MaterialMaps& b, const Tensor& inside) {
  const Tensor x = a.normal.to(torch::kDouble), y = b.normal.to(torch::kDouble);
  const Tensor angle = torch::atan2(torch::cross(x, y, 1).norm(2, 1), (x * y).sum(1));
  return angle.masked_select(inside) * (180 / M_PI);
}

/// (classes, maps, 1, 1): what each class of the table states of each of the rss network's maps, in units of
/// its span.
Tensor class_table() {
  static const MaterialTable table = read_material_table(program_file("assets/materials.xml"));
  std::vector<double> values;
  for (const ClassMaterial& c : table)
    for (const LearnedMap& map : kMaps)
      for (const MaterialMap& stated : kMaterialMaps)
        if (is_of_rss(map) && stated.texels == map.texels) values.push_back(c.*stated.value / map.span);
  return torch::tensor(values, torch::kDouble)
      .view({static_cast<int64_t>(table.size()), rss_channels(), 1, 1});
}

/// (B, maps, H, W): the rss network's maps in units of their spans.
Tensor materials_of(const MaterialMaps& maps) {
  std::vector<Tensor> channels;
  for (const LearnedMap& map : kMaps)
    if (is_of_rss(map)) channels.push_back((maps.*map.tensor).to(torch::kDouble) / map.span);
  return torch::cat(channels, 1);
}

double class_iou(const MaterialMaps& estimate, const MaterialMaps& truth, const Tensor& inside) {
  const Tensor mine = nearest_classes(estimate).masked_select(inside),
               wanted = nearest_classes(truth).masked_select(inside);
  double sum = 0;
  int classes = 0;
  for (int64_t c = 0; c < static_cast<int64_t>(kClassCount); ++c) {
    const Tensor found = mine == c, there = wanted == c;
    if (!there.any().item<bool>()) continue;
    sum += (found & there).sum().item<double>() / (found | there).sum().item<double>();
    ++classes;
  }
  return sum / classes;
}

}  // namespace

double ssim(const Tensor& a, const Tensor& b, const Tensor& mask) {
  const Tensor weight = mask.to(torch::kDouble).expand(a.sizes()).contiguous();
  const Tensor total = windowed(weight).clamp_min(1e-12);
  const auto mean = [&](const Tensor& x) { return windowed(x * weight) / total; };
  const Tensor x = a.to(torch::kDouble), y = b.to(torch::kDouble);
  const Tensor x_mean = mean(x), y_mean = mean(y);
  const Tensor x_variance = mean(x * x) - x_mean.square(), y_variance = mean(y * y) - y_mean.square();
  const Tensor covariance = mean(x * y) - x_mean * y_mean;
  const Tensor map = (2 * x_mean * y_mean + kC1) * (2 * covariance + kC2) /
                     ((x_mean.square() + y_mean.square() + kC1) * (x_variance + y_variance + kC2));
  return map.masked_select((mask > 0.5).expand(map.sizes())).mean().item<double>();
}

Tensor nearest_classes(const MaterialMaps& maps) {
  return (materials_of(maps).unsqueeze(1) - class_table()).square().sum(2).argmin(1);
}

Measures albedo_measures(const Tensor& estimate, const Tensor& truth, const Tensor& mask) {
  Measures measures = no_measures();
  if (!torch::isfinite(estimate).all().item<bool>()) return measures;
  const Tensor inside = (mask > 0.5).expand(estimate.sizes());
  const Tensor p = estimate.masked_select(inside).to(torch::kDouble),
               g = truth.masked_select(inside).to(torch::kDouble);
  const double factor = (p * g).sum().item<double>() / std::max(1e-12, (p * p).sum().item<double>());
  const Tensor wanted = srgb_of(truth);
  measures[kAlbedoScaled_dB] = psnr(srgb_of((estimate * factor).clamp(0, 1)), wanted, mask).masked;
  measures[kAlbedoSsim] = ssim(srgb_of(estimate), wanted, mask);
  return measures;
}

Measures measures_of(const MaterialMaps& estimate, const MaterialMaps& truth, const Tensor& mask) {
  torch::NoGradGuard no_gradients;
  const Tensor inside = (mask > 0.5)[0];
  Measures measures = albedo_measures(estimate.diffuse, truth.diffuse, mask);
  const Tensor angles = normal_angles(estimate, truth, inside);
  measures[kNormalMean_deg] = angles.mean().item<double>();
  measures[kNormalMedian_deg] = angles.median().item<double>();
  const bool has_materials =
      torch::isfinite(materials_of(estimate).sum(1, true)).masked_select(mask > 0.5).all().item<bool>();
  if (has_materials) measures[kClassIou] = class_iou(estimate, truth, inside);
  return measures;
}

Interval bootstrap_of_mean(const std::vector<double>& values) {
  const bool is_whole =
      !values.empty() && std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
  if (!is_whole) return {std::nan(""), std::nan("")};
  std::vector<double> means;
  const auto count = static_cast<double>(values.size());
  for (uint64_t resample = 0; resample < kResamples; ++resample) {
    double sum = 0;
    for (uint64_t i = 0; i < values.size(); ++i)
      sum += values[static_cast<size_t>(uniform_of(key_of({resample}), i) * count)];
    means.push_back(sum / count);
  }
  std::sort(means.begin(), means.end());
  const auto at = [&](double share) {
    return means[static_cast<size_t>(std::lround(share * (kResamples - 1)))];
  };
  return {at(kTail), at(1 - kTail)};
}

}  // namespace ohb::learner
