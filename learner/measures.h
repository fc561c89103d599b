// What PSNR does not say of estimated maps: angles of normals, albedo up to its scale, its structure, and the
// materials that roughness, specular and subsurface stand for.
#pragma once

#include <array>
#include <vector>

#include "learner/maps.h"

namespace ohb::learner {

/// What is measured of one picture, over the pixels with mask > 0.5. NaN where a map that it needs is NaN.
enum Measure : size_t {
  kNormalMean_deg,    // angle between the normals: its mean
  kNormalMedian_deg,  // its median
  kAlbedoScaled_dB,  // PSNR of sRGB-encoded albedo after the one factor on the linear estimate that fits best
  kAlbedoSsim,       // structural similarity of sRGB-encoded albedo
  kClassIou,  // intersection over union of skin, hair, fabric and leather, mean over those in the truth
  kMeasureCount
};
constexpr std::array<const char*, kMeasureCount> kMeasureNames = {"N mean deg", "N median deg", "D scaled dB",
                                                                  "D SSIM", "class IoU"};
/// Whether more of it is better.
constexpr std::array<bool, kMeasureCount> kMoreIsBetter = {false, false, true, true, true};
using Measures = std::array<double, kMeasureCount>;

/// Maps (1, C, H, W) and mask (1, 1, H, W) with some foreground.
Measures measures_of(const MaterialMaps& estimate, const MaterialMaps& truth, const torch::Tensor& mask);

/// Those of an albedo alone, linear (1, 3, H, W); the others are NaN.
Measures albedo_measures(const torch::Tensor& estimate, const torch::Tensor& truth,
                         const torch::Tensor& mask);

/// Structural similarity (Wang, Bovik, Sheikh and Simoncelli 2004): Gaussian window of 11 pixels, sigma 1.5,
/// C1 = 0.01^2, C2 = 0.03^2, values in [0, 1]. Windows weigh their pixels by the mask too, so that what is
/// beyond the outline does not count; mean over channels and over the pixels with mask > 0.5.
double ssim(const torch::Tensor& a, const torch::Tensor& b, const torch::Tensor& mask);

/// (1, H, W) of class numbers in the order of kClassNames: the nearest of assets/materials.xml, each of the
/// rss network's maps in units of its span there (LearnedMap::span).
torch::Tensor nearest_classes(const MaterialMaps& maps);

/// 5 % and 95 % points of the mean over people drawn with replacement, 2000 times (percentile bootstrap,
/// Efron and Tibshirani 1993); a function of the values alone. NaN if one of them is, or if there is none.
struct Interval {
  double low, high;
};
Interval bootstrap_of_mean(const std::vector<double>& values);

}  // namespace ohb::learner
