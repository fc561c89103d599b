// Do two renderers compute the same image? Tests on K independently seeded images a side. Pixels of one
// image are not independent of each other (QMC patterns, shared tables), so only seeds count as samples.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "dataset/model/image.h"

namespace ohb::validation {

/// One image a seed: equal sizes, at least 3 channels, of which the first three (linear RGB, premultiplied)
/// are used.
using ImageStack = std::vector<Image>;

/// Mean over the seeds (3 channels), and variance of a single seed's image (unbiased, 3 channels).
struct Moments {
  Image mean, variance;
};
Moments moments_of(const ImageStack& stack);

/// Pixels by what they may be used for, row by row, 1 or 0.
struct PixelSets {
  std::vector<uint8_t> foreground;  // coverage above 1e-5 in either renderer
  std::vector<uint8_t>
      band;  // within 1 px of the outline: coverage 0 and above 0 meet in the 3 x 3 px around
  std::vector<uint8_t> inside;  // foreground and not band
};
/// From the coverage of both renderers (1 channel each, or the last channel of 4).
PixelSets pixel_sets(const Image& coverage_a, const Image& coverage_b);

/// Welch's unequal-variance t statistic of two sets of values, with Satterthwaite's degrees of freedom.
struct WelchTest {
  double t = 0, dof = 1, p = 1;  // p: two-sided
  double standard_error = 0;     // of the difference, floor included
};
/// `floor` is added to the standard error of the difference in quadrature. Needs 2 values a side.
WelchTest welch_test(const std::vector<double>& a, const std::vector<double>& b, double floor);

/// The floor under the standard error: differences that small are not the subject of the bin test (rounding,
/// 1e-4 tangents; and K equal values by chance do not make a difference significant). Stated in the report.
struct ErrorFloor {
  double relative = 0.002;        // of the bin's mean of both
  double of_image_mean = 0.0005;  // of the mean over all tested pixels
};

struct BinTest {
  size_t bins = 0, accepted = 0;  // a bin is accepted if each of its three channels is
  double accepted_share = 1;
  double single_alpha = 0;     // significance of one channel of one bin: Sidak's 1 - (1 - alpha)^(1 / tests)
  double below_5_percent = 0;  // share of tests with p < .05; .05 if all is well and noise is normal
  double median_detectable = 0;  // relative difference that would be rejected in the median bin
  Image z;  // 1 channel, image size: signed z of the bin's mean of RGB, 0 where not tested
};

/// Tests blocks of bin_px x bin_px pixels, of which only those in `pixels` count (a bin without any is left
/// out): a seed's value is the mean over the bin's pixels; Welch's test compares the K values a side, in each
/// channel. "Accepted": p >= single_alpha. If both renderers agree (and seed means are about normal) ALL bins
/// are accepted with probability 1 - alpha: that is the false-alarm rate. (Mitsuba 3's image test with t
/// instead of z; Sidak 1967.) Needs 2 seeds a side.
BinTest test_bins(const ImageStack& a, const ImageStack& b, const std::vector<uint8_t>& pixels,
                  int bin_px = 3, double alpha = 0.01, const ErrorFloor& floor = {});

struct Interval {
  double value = 1, low = 1, high = 1;
  double share_a = 0.5;  // of the variance behind it that is the first side's
};

/// Ratio of means a / b with its 95 % interval from the spread over seeds: delta method, and Student's t with
/// Satterthwaite's degrees of freedom. (0 / 0 is 1 exactly; x / 0 is infinite.)
Interval ratio_of_means(const std::vector<double>& a, const std::vector<double>& b);

struct RegionRatio {
  std::string name;
  double weight_px = 0;                   // sum of the weights
  double mean_a[3] = {}, mean_b[3] = {};  // weighted means over the region
  Interval channel[3], total;             // total: of the sum of channels
};

/// Weighted mean of a region in both stacks. `weights`: one a pixel (share of the class; 1 for all).
RegionRatio compare_region(const std::string& name, const ImageStack& a, const ImageStack& b,
                           const std::vector<float>& weights);

/// Signed relative difference (a - b) / max(b, 1 % of b's mean over `pixels`) of the channel means, averaged
/// over bins of bin_px; 1 channel, 0 outside `pixels`.
Image relative_difference(const Image& mean_a, const Image& mean_b, const std::vector<uint8_t>& pixels,
                          int bin_px = 3);

/// Mean of the variance over `pixels` and channels: the mean squared error of one seed's unbiased image.
double mean_variance(const Moments& moments, const std::vector<uint8_t>& pixels);

}  // namespace ohb::validation
