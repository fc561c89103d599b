#include "renderer/budget.h"

#include <algorithm>
#include <cmath>

namespace ohb {
namespace {

constexpr int kBlock_px = 4;
constexpr double kLeastShare = 0.25, kMostShare = 16;

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

/// Sums over blocks of pixels and, in `pooled`, over each block and its neighbours.
struct Blocks {
  int across;
  std::vector<double> variance, work, pixels;
  double pooled_share(int bx, int by) const {
    double v = 0, w = 0;
    for (int y = std::max(0, by - 1); y <= std::min(across - 1, by + 1); ++y)
      for (int x = std::max(0, bx - 1); x <= std::min(across - 1, bx + 1); ++x) {
        v += variance[static_cast<size_t>(y) * across + x];
        w += work[static_cast<size_t>(y) * across + x];
      }
    return w > 0 ? std::sqrt(v / w) : 0;
  }
};

}  // namespace

std::vector<uint32_t> adaptive_budget(const Pilots& pilots, const std::vector<uint8_t>& seen, int size_px,
                                      double mean_spp) {
  const std::vector<double> mean_squares = mean_squares_of(pilots.images);
  Blocks blocks{(size_px + kBlock_px - 1) / kBlock_px, {}, {}, {}};
  blocks.variance.assign(static_cast<size_t>(blocks.across) * blocks.across, 0);
  blocks.work = blocks.pixels = blocks.variance;
  for (int y = 0; y < size_px; ++y)
    for (int x = 0; x < size_px; ++x) {
      if (!seen[static_cast<size_t>(y) * size_px + x]) continue;
      const size_t block = static_cast<size_t>(y / kBlock_px) * blocks.across + x / kBlock_px;
      blocks.variance[block] += variance_at(pilots.images, mean_squares, x, y);
      blocks.work[block] += pilots.work.empty() ? 1 : pilots.work[static_cast<size_t>(y) * size_px + x];
      blocks.pixels[block] += 1;
    }
  std::vector<double> share(blocks.variance.size());
  double sum = 0, pixels = 0;
  for (int by = 0; by < blocks.across; ++by)
    for (int bx = 0; bx < blocks.across; ++bx) {
      const size_t block = static_cast<size_t>(by) * blocks.across + bx;
      share[block] = blocks.pooled_share(bx, by);
      sum += share[block] * blocks.pixels[block];
      pixels += blocks.pixels[block];
    }
  if (!(sum > 0)) std::fill(share.begin(), share.end(), 1.0), sum = pixels;
  // The limits take from some what others have too much of: a few rounds settle the sum.
  double scale = pixels / sum;
  const auto limited = [&](double v) { return std::clamp(v * scale, kLeastShare, kMostShare); };
  for (int round = 0; round < 8; ++round) {
    double total = 0;
    for (size_t b = 0; b < share.size(); ++b) total += limited(share[b]) * blocks.pixels[b];
    scale *= pixels / total;
  }
  std::vector<uint32_t> budget(seen.size(), 0);
  for (int y = 0; y < size_px; ++y)
    for (int x = 0; x < size_px; ++x) {
      const size_t i = static_cast<size_t>(y) * size_px + x;
      const double wanted =
          mean_spp * limited(share[static_cast<size_t>(y / kBlock_px) * blocks.across + x / kBlock_px]);
      if (seen[i]) budget[i] = static_cast<uint32_t>(std::max(1.0, std::round(wanted)));
    }
  return budget;
}

}  // namespace ohb
