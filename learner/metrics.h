// How near estimated maps are to the truth: the paper's columns.
#pragma once

#include <array>
#include <nlohmann/json.hpp>
#include <string>

#include "learner/maps.h"

namespace ohb::learner {

constexpr std::array<const char*, kMaps.size() + 1> column_names() {
  std::array<const char*, kMaps.size() + 1> names{};
  for (size_t i = 0; i < kMaps.size(); ++i) names[i] = kMaps[i].column;
  names[kMaps.size()] = "Point";
  return names;
}

/// Columns of the paper's tables: those of kMaps, and the picture relit by the fixed point light.
constexpr auto kColumns = column_names();

/// Decibels. PSNR = 10 log10(1 / MSE) over pixels and channels of values in [0, 1], at most 100.
struct Psnr {
  double masked = 0;  // over the pixels with mask > 0.5
  double full = 0;    // over the whole frame, both pictures multiplied by the mask

  Psnr operator+(const Psnr& other) const { return {masked + other.masked, full + other.full}; }
  Psnr operator/(double divisor) const { return {masked / divisor, full / divisor}; }
};

/// a and b (1, C, H, W), mask (1, 1, H, W) with some foreground.
Psnr psnr(const torch::Tensor& a, const torch::Tensor& b, const torch::Tensor& mask);

/// What the columns compare, each (1, C, H, W) in [0, 1]: stored_values of each map, and the relit picture
/// sRGB-encoded.
std::array<torch::Tensor, kColumns.size()> columns_of(const MaterialMaps& maps);

/// The mean of scores, an array or vector of Psnr or of numbers, column by column.
template <typename List>
class MeanOf {
 public:
  void add(const List& scores) {
    if (count_++ == 0) {
      sum_ = scores;
      return;
    }
    for (size_t i = 0; i < scores.size(); ++i) sum_[i] = sum_[i] + scores[i];
  }
  size_t count() const { return count_; }
  List mean() const {
    List scores = sum_;
    for (auto& score : scores) score = score / static_cast<double>(count_);
    return scores;
  }

 private:
  List sum_{};
  size_t count_ = 0;
};

/// One row's scores of one picture.
using Scores = std::array<Psnr, kColumns.size()>;
Scores scores_of(const MaterialMaps& estimate, const MaterialMaps& truth, const torch::Tensor& mask);
/// Mean of the maps' columns, without the relit picture's: of Psnr::masked or Psnr::full.
double maps_mean(const Scores& scores, double Psnr::*value);

/// A cell of a table of at least `width` characters, with the bar after it: "  12.34 |"; a dash if not
/// finite.
std::string table_cell(double value, size_t width = 6);
/// Null if not finite.
nlohmann::json json_number(double value);

/// Every value rounded to 8 bits in its encoding: what storing the truth in 8-bit PNG costs.
MaterialMaps eight_bit(const MaterialMaps& maps);

}  // namespace ohb::learner
