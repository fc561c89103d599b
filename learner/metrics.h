// How near estimated maps are to the truth: the paper's columns.
#pragma once

#include <array>

#include "learner/maps.h"

namespace ohb {

/// Columns of the paper's tables: normal, diffuse, roughness, specular, subsurface, displacement, and the
/// picture relit by the fixed point light.
constexpr std::array<const char*, 7> kColumns = {"N", "D", "R", "S", "SSS", "Disp", "Point"};
constexpr size_t kMaterialColumns = 6;

/// Decibels. PSNR = 10 log10(1 / MSE) over pixels and channels of values in [0, 1], at most 100.
struct Psnr {
  double masked = 0;  // over the pixels with mask > 0.5
  double full = 0;    // over the whole frame, both pictures multiplied by the mask
};

/// a and b (1, C, H, W), mask (1, 1, H, W) with some foreground.
Psnr psnr(const torch::Tensor& a, const torch::Tensor& b, const torch::Tensor& mask);

/// What the columns compare, each (1, C, H, W) in [0, 1]: normal as (n + 1) / 2, diffuse and the relit
/// picture sRGB-encoded, displacement as 0.5 + d / 2, the others as they are.
std::array<torch::Tensor, kColumns.size()> columns_of(const MaterialMaps& maps);

/// One row's scores of one picture.
using Scores = std::array<Psnr, kColumns.size()>;
Scores scores_of(const MaterialMaps& estimate, const MaterialMaps& truth, const torch::Tensor& mask);

/// Every value rounded to 8 bits in its encoding: what storing the truth in 8-bit PNG costs.
MaterialMaps eight_bit(const MaterialMaps& maps);

}  // namespace ohb
