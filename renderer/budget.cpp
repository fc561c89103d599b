#include "renderer/budget.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "renderer/sampling.h"

namespace ohb {
namespace {

constexpr int kPool_px = 2;  // the neighbours on each side that a pixel's noise is told from
constexpr double kLeastShare = 0.25, kMostShare = 16;
constexpr double kOwnLog2 = 0.1;

/// Variance of the pilots' mean radiance at one pixel, relative to the lights' mean squares.
double variance_at(const std::vector<std::vector<SampleLight>>& pilots,
                   const std::vector<double>& mean_squares, int x, int y) {
  const double count = static_cast<double>(pilots.size());
  double variance = 0;
  for (size_t l = 0; l < mean_squares.size(); ++l)
    for (int c = 0; c < 3 && mean_squares[l] > 0; ++c) {
      double sum = 0, squares = 0;
      for (const std::vector<SampleLight>& pilot : pilots) {
        const double value = pilot[l].radiance.pixel(x, y)[c];
        sum += value, squares += value * value;
      }
      variance += std::max(0.0, squares - sum * sum / count) / (count - 1) / mean_squares[l];
    }
  return variance;
}

std::vector<double> mean_squares_of(const std::vector<std::vector<SampleLight>>& pilots) {
  std::vector<double> squares;
  for (size_t l = 0; l < pilots.front().size(); ++l) {
    squares.push_back(0);
    for (const std::vector<SampleLight>& pilot : pilots)
      for (const float value : pilot[l].radiance.values) squares.back() += double{value} * value;
  }
  return squares;
}

/// What the pilots say of each pixel.
struct Noise {
  int size_px;
  std::vector<double> variance, work;
  /// The root of variance over work about one pixel; neighbours count less the farther they are.
  double pooled_share(int x0, int y0) const {
    double v = 0, w = 0;
    for (int y = std::max(0, y0 - kPool_px); y <= std::min(size_px - 1, y0 + kPool_px); ++y)
      for (int x = std::max(0, x0 - kPool_px); x <= std::min(size_px - 1, x0 + kPool_px); ++x) {
        const double weight = std::exp(-0.5 * ((x - x0) * (x - x0) + (y - y0) * (y - y0)));
        v += weight * variance[static_cast<size_t>(y) * size_px + x];
        w += weight * work[static_cast<size_t>(y) * size_px + x];
      }
    return w > 0 ? std::sqrt(v / w) : 0;
  }
};

}  // namespace

std::vector<uint32_t> adaptive_budget(const Pilots& pilots, const std::vector<uint8_t>& seen, int size_px,
                                      double mean_spp) {
  const std::vector<double> mean_squares = mean_squares_of(pilots.images);
  Noise noise{size_px, std::vector<double>(seen.size(), 0), std::vector<double>(seen.size(), 0)};
  double pixels = 0;
  for (int y = 0; y < size_px; ++y)
    for (int x = 0; x < size_px; ++x) {
      const size_t i = static_cast<size_t>(y) * size_px + x;
      if (!seen[i]) continue;
      noise.variance[i] = variance_at(pilots.images, mean_squares, x, y);
      noise.work[i] = pilots.work.empty() ? 1 : pilots.work[i];
      pixels += 1;
    }
  std::vector<double> share(seen.size(), 0);
  double sum = 0;
  for (int y = 0; y < size_px; ++y)
    for (int x = 0; x < size_px; ++x) {
      const size_t i = static_cast<size_t>(y) * size_px + x;
      if (seen[i]) sum += share[i] = noise.pooled_share(x, y);
    }
  if (!(sum > 0)) std::fill(share.begin(), share.end(), 1.0), sum = pixels;
  // The limits take from some what others have too much of: a few rounds settle the sum.
  double scale = pixels / sum;
  const auto limited = [&](double v) { return std::clamp(v * scale, kLeastShare, kMostShare); };
  for (int round = 0; round < 8; ++round) {
    double total = 0;
    for (size_t i = 0; i < share.size(); ++i) total += seen[i] ? limited(share[i]) : 0;
    scale *= pixels / total;
  }
  std::vector<uint32_t> budget(seen.size(), 0);
  for (size_t i = 0; i < seen.size(); ++i)
    if (seen[i]) budget[i] = static_cast<uint32_t>(std::max(1.0, std::round(mean_spp * limited(share[i]))));
  return budget;
}

std::vector<uint32_t> powers_of_two(const std::vector<uint32_t>& budget) {
  const auto sum_of = [](const std::vector<uint32_t>& paths) {
    return std::accumulate(paths.begin(), paths.end(), uint64_t{0});
  };
  const uint64_t wanted = sum_of(budget);
  // The largest of the scales that keep the sum. Equal budgets must not all jump at once: each has a little
  // of its own.
  std::vector<uint32_t> best(budget.size(), 0);
  double low = -1, high = 1;
  for (int step = 0; step < 16; ++step) {
    const double scale = 0.5 * (low + high);
    std::vector<uint32_t> rounded(budget.size(), 0);
    for (size_t i = 0; i < budget.size(); ++i) {
      if (budget[i] == 0) continue;
      const double own = kOwnLog2 * (static_cast<double>(mix_bits(i) >> 11) * 0x1p-53 - 0.5);
      rounded[i] =
          1u << static_cast<int>(std::clamp(std::round(std::log2(budget[i]) + own + scale), 0.0, 31.0));
    }
    const bool fits = sum_of(rounded) <= wanted;
    (fits ? low : high) = scale;
    if (fits) best = std::move(rounded);
  }
  return sum_of(best) > 0 ? best : budget;
}

}  // namespace ohb
