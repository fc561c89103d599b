#include "learner/metrics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "learner/oracle.h"
#include "learner/task.h"

namespace ohb::learner {
namespace {

using torch::Tensor;

constexpr double kMost_dB = 100;

double decibels(double mse) {
  return std::isfinite(mse) ? std::min(kMost_dB, -10 * std::log10(std::max(mse, 1e-12))) : std::nan("");
}

}  // namespace

Psnr psnr(const Tensor& a, const Tensor& b, const Tensor& mask) {
  const double channels = static_cast<double>(a.size(1));
  const Tensor squared = (a - b).to(torch::kDouble).square();
  const Tensor inside = (mask > 0.5).to(torch::kDouble);
  const Tensor whole = ((a - b) * mask).to(torch::kDouble).square();
  Psnr result;
  result.masked =
      decibels((squared * inside).sum().item<double>() / (channels * inside.sum().item<double>()));
  result.full = decibels(whole.mean().item<double>());
  return result;
}

std::array<Tensor, kColumns.size()> columns_of(const MaterialMaps& maps) {
  std::array<Tensor, kColumns.size()> columns;
  for (size_t i = 0; i < kMaps.size(); ++i) columns[i] = stored_values(kMaps[i], maps);
  columns[kMaps.size()] = srgb_of(render_maps(maps, {evaluation_light()}).squeeze(1));
  return columns;
}

double maps_mean(const Scores& scores, double Psnr::*value) {
  double sum = 0;
  for (size_t i = 0; i < kMaps.size(); ++i) sum += scores[i].*value;
  return sum / static_cast<double>(kMaps.size());
}

Scores scores_of(const MaterialMaps& estimate, const MaterialMaps& truth, const Tensor& mask) {
  torch::NoGradGuard no_gradients;
  const auto mine = columns_of(estimate), wanted = columns_of(truth);
  Scores scores;
  for (size_t i = 0; i < scores.size(); ++i) scores[i] = psnr(mine[i], wanted[i], mask);
  return scores;
}

std::string table_cell(double value, size_t width) {
  const std::string text = std::isfinite(value) ? fmt::format("{:.2f}", value) : "-";
  return fmt::format(" {:>{}} |", text, std::max<size_t>(6, width));
}

nlohmann::json json_number(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

MaterialMaps eight_bit(const MaterialMaps& maps) {
  const Tensor codes = (encoded_maps(Task::kFinetune, maps).clamp(0, 1) * 255).round() / 255;
  return maps_of(Task::kFinetune, codes, maps);
}

}  // namespace ohb::learner
