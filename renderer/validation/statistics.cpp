#include "renderer/validation/statistics.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "renderer/student_t.h"

namespace ohb::validation {
namespace {

struct Spread {
  double mean = 0, variance = 0;  // unbiased
};

Spread spread_of(const std::vector<double>& values) {
  Spread spread;
  for (const double v : values) spread.mean += v / static_cast<double>(values.size());
  for (const double v : values) spread.variance += (v - spread.mean) * (v - spread.mean);
  if (values.size() > 1) spread.variance /= static_cast<double>(values.size() - 1);
  return spread;
}

/// Satterthwaite's degrees of freedom of the sum of two estimated variances of means.
double satterthwaite(double va, size_t na, double vb, size_t nb) {
  const double below = va * va / static_cast<double>(na - 1) + vb * vb / static_cast<double>(nb - 1);
  return below > 0 ? (va + vb) * (va + vb) / below : static_cast<double>(na + nb - 2);
}

/// Calls `use` with the pixels (indices) of each bin that has some.
void for_each_bin(int width, int height, const std::vector<uint8_t>& pixels, int bin_px,
                  const std::function<void(const std::vector<size_t>&)>& use) {
  std::vector<size_t> bin;
  for (int y0 = 0; y0 < height; y0 += bin_px)
    for (int x0 = 0; x0 < width; x0 += bin_px) {
      bin.clear();
      for (int y = y0; y < std::min(y0 + bin_px, height); ++y)
        for (int x = x0; x < std::min(x0 + bin_px, width); ++x) {
          const size_t pixel = static_cast<size_t>(y) * width + x;
          if (pixels[pixel]) bin.push_back(pixel);
        }
      if (!bin.empty()) use(bin);
    }
}

/// Each seed's mean over the bin, by channel; the fourth is the mean of the three.
void seed_means(const ImageStack& stack, const std::vector<size_t>& bin, std::vector<double> means[4]) {
  for (int c = 0; c < 4; ++c) means[c].assign(stack.size(), 0.0);
  for (size_t k = 0; k < stack.size(); ++k) {
    for (const size_t pixel : bin)
      for (int c = 0; c < 3; ++c) means[c][k] += stack[k].values[pixel * stack[k].channels + c];
    for (int c = 0; c < 3; ++c) {
      means[c][k] /= static_cast<double>(bin.size());
      means[3][k] += means[c][k] / 3;
    }
  }
}

double mean_over(const Image& image, const std::vector<uint8_t>& pixels) {
  double sum = 0, count = 0;
  for (size_t i = 0; i < pixels.size(); ++i)
    if (pixels[i]) {
      for (int c = 0; c < 3; ++c) sum += image.values[i * image.channels + c];
      count += 3;
    }
  return count > 0 ? sum / count : 0;
}

/// Cycles' alpha is 1 - transparency, with a rounding error of about 1e-7 where there is nothing.
constexpr float kLeastCoverage = 1e-5f;

bool covered(const Image& coverage, size_t pixel) {
  return coverage.values[pixel * coverage.channels + coverage.channels - 1] > kLeastCoverage;
}

/// What test_bins gathers over the bins.
struct BinTally {
  BinTest result;
  size_t tests = 0, below_5_percent = 0;
  std::vector<double> detectable;

  void add(const std::vector<double> a[4], const std::vector<double> b[4], const std::vector<size_t>& bin,
           double floor_of_image, const ErrorFloor& floor) {
    bool accepted = true;
    double z = 0, detectable_here = 0;
    for (int c = 0; c < 4; ++c) {
      const double level = 0.5 * (spread_of(a[c]).mean + spread_of(b[c]).mean);
      const WelchTest test = welch_test(a[c], b[c], std::hypot(floor.relative * level, floor_of_image));
      if (c == 3) {
        z = std::copysign(renderer::normal_two_sided_quantile(test.p), test.t);
        detectable_here = renderer::student_two_sided_quantile(result.single_alpha, test.dof) *
                          test.standard_error / std::max(level, 1e-30);
        continue;
      }
      accepted = accepted && test.p >= result.single_alpha;
      below_5_percent += test.p < 0.05;
    }
    tests += 3;
    result.bins += 1;
    result.accepted += accepted;
    detectable.push_back(detectable_here);
    for (const size_t pixel : bin) result.z.values[pixel] = static_cast<float>(z);
  }
};

}  // namespace

Moments moments_of(const ImageStack& stack) {
  const Image& first = stack.front();
  Moments moments{Image(first.width_px, first.height_px, 3), Image(first.width_px, first.height_px, 3)};
  std::vector<double> values(stack.size());
  for (size_t i = 0; i < moments.mean.values.size(); ++i) {
    for (size_t k = 0; k < stack.size(); ++k) values[k] = stack[k].values[i / 3 * stack[k].channels + i % 3];
    const Spread spread = spread_of(values);
    moments.mean.values[i] = static_cast<float>(spread.mean);
    moments.variance.values[i] = static_cast<float>(spread.variance);
  }
  return moments;
}

PixelSets pixel_sets(const Image& coverage_a, const Image& coverage_b) {
  const int width = coverage_a.width_px, height = coverage_a.height_px;
  PixelSets sets;
  sets.foreground.resize(static_cast<size_t>(width) * height);
  for (size_t i = 0; i < sets.foreground.size(); ++i)
    sets.foreground[i] = covered(coverage_a, i) || covered(coverage_b, i);
  sets.band.assign(sets.foreground.size(), 0);
  sets.inside = sets.foreground;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      int count = 0, total = 0;
      for (int v = std::max(y - 1, 0); v <= std::min(y + 1, height - 1); ++v)
        for (int u = std::max(x - 1, 0); u <= std::min(x + 1, width - 1); ++u, ++total)
          count += sets.foreground[static_cast<size_t>(v) * width + u];
      if (count == 0 || count == total) continue;
      sets.band[static_cast<size_t>(y) * width + x] = 1;
      sets.inside[static_cast<size_t>(y) * width + x] = 0;
    }
  return sets;
}

WelchTest welch_test(const std::vector<double>& a, const std::vector<double>& b, double floor) {
  const Spread sa = spread_of(a), sb = spread_of(b);
  const double va = sa.variance / static_cast<double>(a.size()),
               vb = sb.variance / static_cast<double>(b.size());
  WelchTest test;
  test.standard_error = std::sqrt(va + vb + floor * floor);
  test.dof = satterthwaite(va, a.size(), vb, b.size());
  const double difference = sa.mean - sb.mean;
  if (difference != 0)
    test.t = test.standard_error > 0 ? difference / test.standard_error
                                     : std::copysign(std::numeric_limits<double>::infinity(), difference);
  test.p = renderer::student_two_sided_p(test.t, test.dof);
  return test;
}

BinTest test_bins(const ImageStack& a, const ImageStack& b, const std::vector<uint8_t>& pixels, int bin_px,
                  double alpha, const ErrorFloor& floor) {
  const int width = a.front().width_px, height = a.front().height_px;
  size_t bins = 0;
  for_each_bin(width, height, pixels, bin_px, [&bins](const std::vector<size_t>&) { ++bins; });
  BinTally tally;
  tally.result.z = Image(width, height, 1);
  if (bins == 0) return tally.result;
  tally.result.single_alpha = -std::expm1(std::log1p(-alpha) / static_cast<double>(3 * bins));
  const double image_mean = mean_over(moments_of(b).mean, pixels);
  std::vector<double> means_a[4], means_b[4];
  for_each_bin(width, height, pixels, bin_px, [&](const std::vector<size_t>& bin) {
    seed_means(a, bin, means_a);
    seed_means(b, bin, means_b);
    tally.add(means_a, means_b, bin, floor.of_image_mean * image_mean, floor);
  });
  BinTest& result = tally.result;
  result.accepted_share = static_cast<double>(result.accepted) / static_cast<double>(result.bins);
  result.below_5_percent = static_cast<double>(tally.below_5_percent) / static_cast<double>(tally.tests);
  const auto middle = tally.detectable.begin() + static_cast<std::ptrdiff_t>(tally.detectable.size() / 2);
  std::nth_element(tally.detectable.begin(), middle, tally.detectable.end());
  result.median_detectable = *middle;
  return result;
}

Interval ratio_of_means(const std::vector<double>& a, const std::vector<double>& b) {
  const Spread sa = spread_of(a), sb = spread_of(b);
  if (sa.mean == 0 && sb.mean == 0) return {};
  Interval interval;
  interval.value = sb.mean != 0 ? sa.mean / sb.mean : std::numeric_limits<double>::infinity();
  if (sa.mean == 0 || sb.mean == 0) return {interval.value, interval.value, interval.value};
  // Relative variances of both means: var(r) / r^2 to first order.
  const double va = sa.variance / static_cast<double>(a.size()) / (sa.mean * sa.mean);
  const double vb = sb.variance / static_cast<double>(b.size()) / (sb.mean * sb.mean);
  const double dof = satterthwaite(va, a.size(), vb, b.size());
  const double reach =
      renderer::student_two_sided_quantile(0.05, dof) * std::sqrt(va + vb) * std::fabs(interval.value);
  interval.low = interval.value - reach;
  interval.high = interval.value + reach;
  if (va + vb > 0) interval.share_a = va / (va + vb);
  return interval;
}

RegionRatio compare_region(const std::string& name, const ImageStack& a, const ImageStack& b,
                           const std::vector<float>& weights) {
  RegionRatio region;
  region.name = name;
  for (const float weight : weights) region.weight_px += weight;
  const auto sums_of = [&](const ImageStack& stack, std::vector<double> sums[4]) {
    for (int c = 0; c < 4; ++c) sums[c].assign(stack.size(), 0.0);
    for (size_t k = 0; k < stack.size(); ++k)
      for (size_t i = 0; i < weights.size(); ++i)
        if (weights[i] > 0)
          for (int c = 0; c < 3; ++c) {
            const double value = static_cast<double>(weights[i]) * stack[k].values[i * stack[k].channels + c];
            sums[c][k] += value;
            sums[3][k] += value;
          }
  };
  std::vector<double> sums_a[4], sums_b[4];
  sums_of(a, sums_a);
  sums_of(b, sums_b);
  for (int c = 0; c < 3; ++c) {
    region.mean_a[c] = region.weight_px > 0 ? spread_of(sums_a[c]).mean / region.weight_px : 0;
    region.mean_b[c] = region.weight_px > 0 ? spread_of(sums_b[c]).mean / region.weight_px : 0;
    region.channel[c] = ratio_of_means(sums_a[c], sums_b[c]);
  }
  region.total = ratio_of_means(sums_a[3], sums_b[3]);
  return region;
}

Image relative_difference(const Image& mean_a, const Image& mean_b, const std::vector<uint8_t>& pixels,
                          int bin_px) {
  Image difference(mean_b.width_px, mean_b.height_px, 1);
  const double least = 0.01 * mean_over(mean_b, pixels);
  for_each_bin(mean_b.width_px, mean_b.height_px, pixels, bin_px, [&](const std::vector<size_t>& bin) {
    double a = 0, b = 0;
    for (const size_t pixel : bin)
      for (int c = 0; c < 3; ++c) {
        a += mean_a.values[3 * pixel + c];
        b += mean_b.values[3 * pixel + c];
      }
    const double below = std::max(b, 3 * static_cast<double>(bin.size()) * least);
    const float value = below > 0 ? static_cast<float>((a - b) / below) : 0;
    for (const size_t pixel : bin) difference.values[pixel] = value;
  });
  return difference;
}

double mean_variance(const Moments& moments, const std::vector<uint8_t>& pixels) {
  return mean_over(moments.variance, pixels);
}

}  // namespace ohb::validation
