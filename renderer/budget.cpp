#include "renderer/budget.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace ohb::renderer {
namespace {

constexpr int kPool_px = 2;  // the neighbours on each side that a pixel's noise is told from
constexpr double kLeastShare = 0.25, kMostShare = 16;
// The squared error of n Sobol points is about variance n^-1.3 here (measured), so n in proportion to
// (variance / work)^(1 / 2.3) is best.
constexpr double kSobolExponent = 1 / 2.3;

/// Which pixels' noise counts: all, or all but those of one class.
constexpr int kNoClass = -1;

/// What the pilots say of each pixel.
class Noise {
 public:
  /// `not_of`: the class whose pixels nothing is told of.
  Noise(const Pilots& pilots, const std::vector<uint8_t>& seen, int size_px, int not_of)
      : size_px_(size_px), variance_(seen.size(), 0), work_(seen.size(), 0) {
    std::vector<double> mean_squares(pilots.images.front().size(), 0);
    const auto each = [&](const auto& act) {
      for (int y = 0; y < size_px; ++y)
        for (int x = 0; x < size_px; ++x) {
          const size_t i = static_cast<size_t>(y) * size_px + x;
          if (seen[i] && pixel_class(x, y) != not_of) act(x, y, i);
        }
    };
    each([&](int x, int y, size_t) {
      for (size_t l = 0; l < mean_squares.size(); ++l)
        for (const std::vector<SampleLight>& pilot : pilots.images)
          for (int c = 0; c < 3; ++c) {
            const double value = pilot[l].radiance.pixel(x, y)[c];
            mean_squares[l] += value * value;
          }
    });
    each([&](int x, int y, size_t i) {
      variance_[i] = variance_at(pilots.images, mean_squares, x, y);
      work_[i] = pilots.work.empty() ? 1 : pilots.work[i];
    });
  }
  /// Variance over work about one pixel; neighbours count less the farther they are.
  double pooled(int x0, int y0) const {
    double v = 0, w = 0;
    for (int y = std::max(0, y0 - kPool_px); y <= std::min(size_px_ - 1, y0 + kPool_px); ++y)
      for (int x = std::max(0, x0 - kPool_px); x <= std::min(size_px_ - 1, x0 + kPool_px); ++x) {
        const double weight = std::exp(-0.5 * ((x - x0) * (x - x0) + (y - y0) * (y - y0)));
        v += weight * variance_[static_cast<size_t>(y) * size_px_ + x];
        w += weight * work_[static_cast<size_t>(y) * size_px_ + x];
      }
    return w > 0 ? v / w : 0;
  }

 private:
  /// Variance of the pilots' radiance at one pixel, relative to the lights' mean squares.
  static double variance_at(const std::vector<std::vector<SampleLight>>& pilots,
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

  int size_px_;
  std::vector<double> variance_, work_;
};

/// Paths in proportion to the shares of `members` (1 a pixel that gets some), within limits about their mean.
std::vector<uint32_t> paths_of(std::vector<double> share, const std::vector<uint8_t>& members,
                               double mean_spp) {
  const double pixels = static_cast<double>(std::count(members.begin(), members.end(), 1));
  double sum = std::accumulate(share.begin(), share.end(), 0.0);
  if (!(sum > 0)) std::fill(share.begin(), share.end(), 1.0), sum = pixels;
  // The limits take from some what others have too much of: a few rounds settle the sum.
  double scale = pixels / sum;
  const auto limited = [&](double v) { return std::clamp(v * scale, kLeastShare, kMostShare); };
  for (int round = 0; round < 8; ++round) {
    double total = 0;
    for (size_t i = 0; i < share.size(); ++i) total += members[i] ? limited(share[i]) : 0;
    scale *= pixels / total;
  }
  std::vector<uint32_t> paths(share.size(), 0);
  for (size_t i = 0; i < share.size(); ++i)
    if (members[i]) paths[i] = static_cast<uint32_t>(std::max(1.0, std::round(mean_spp * limited(share[i]))));
  return paths;
}

/// The shares of `members`: the pooled variance over work to the power `exponent`.
std::vector<double> shares_of(const Noise& noise, const std::vector<uint8_t>& members, int size_px,
                              double exponent) {
  std::vector<double> share(members.size(), 0);
  for (int y = 0; y < size_px; ++y)
    for (int x = 0; x < size_px; ++x) {
      const size_t i = static_cast<size_t>(y) * size_px + x;
      if (members[i]) share[i] = std::pow(noise.pooled(x, y), exponent);
    }
  return share;
}

}  // namespace

std::vector<uint32_t> adaptive_budget(const Pilots& pilots, const std::vector<uint8_t>& seen, int size_px,
                                      double mean_spp) {
  const Noise noise(pilots, seen, size_px, kNoClass);
  return paths_of(shares_of(noise, seen, size_px, 0.5), seen, mean_spp);
}

std::vector<uint32_t> continued_budget(const Pilots& begun, uint32_t begun_spp,
                                       const std::vector<uint8_t>& seen, int size_px, double mean_spp) {
  std::vector<uint32_t> budget(seen.size(), 0);
  for (int own = 0; own < kPixelClasses; ++own) {
    std::vector<uint8_t> members(seen.size(), 0);
    for (int y = 0; y < size_px; ++y)
      for (int x = 0; x < size_px; ++x) {
        const size_t i = static_cast<size_t>(y) * size_px + x;
        members[i] = seen[i] && pixel_class(x, y) == own;
      }
    const Noise noise(begun, seen, size_px, own);
    const std::vector<uint32_t> paths =
        paths_of(shares_of(noise, members, size_px, kSobolExponent), members, mean_spp);
    for (size_t i = 0; i < budget.size(); ++i)
      if (members[i]) budget[i] = std::max(paths[i], begun_spp);
  }
  return budget;
}

}  // namespace ohb::renderer
