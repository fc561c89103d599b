#include "dataset/environments/sphere_map.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "dataset/model/environment.h"
#include "dataset/model/parallel.h"

namespace ohb::environments {
namespace {

constexpr double kTwoPi = 6.283185307179586477;

/// cos(pi low / of) - cos(pi high / of), without cancellation.
double cosine_difference(int64_t low, int64_t high, int64_t of) {
  const double half_turn = kTwoPi / 4 / static_cast<double>(of);
  return 2 * std::sin(half_turn * static_cast<double>(low + high)) *
         std::sin(half_turn * static_cast<double>(high - low));
}

/// Calls use(source, weight) for each cell of `from` that overlaps cell `i` of `to` of the same length;
/// `weight(low, high)` is of the overlap in units of 1 / (from x to).
template <class Weight, class Use>
void for_overlaps(int64_t i, int64_t to, int64_t from, const Weight& weight, const Use& use) {
  const int64_t begin = i * from, end = (i + 1) * from;
  for (int64_t source = begin / to; source * to < end; ++source)
    use(source, weight(std::max(begin, source * to), std::min(end, (source + 1) * to)));
}

/// Row `y` of the result: first the mean of the source rows, then along them.
void resample_row(const Image& map, int y, Image& result) {
  const int64_t height = result.height_px, source_height = map.height_px;
  std::vector<double> row(static_cast<size_t>(map.width_px) * 3);
  double total = 0;
  for_overlaps(
      y, height, source_height,
      [&](int64_t low, int64_t high) { return cosine_difference(low, high, height * source_height); },
      [&](int64_t source, double weight) {
        total += weight;
        const float* from = map.pixel(0, static_cast<int>(source));
        for (size_t k = 0; k < row.size(); ++k) row[k] += weight * static_cast<double>(from[k]);
      });
  for (int x = 0; x < result.width_px; ++x) {
    double sum[3] = {};
    for_overlaps(
        x, result.width_px, map.width_px,
        [&](int64_t low, int64_t high) { return static_cast<double>(high - low); },
        [&](int64_t source, double weight) {
          for (size_t c = 0; c < 3; ++c) sum[c] += weight * row[static_cast<size_t>(source) * 3 + c];
        });
    for (int c = 0; c < 3; ++c)
      result.pixel(x, y)[c] = static_cast<float>(sum[c] / (total * static_cast<double>(map.width_px)));
  }
}

}  // namespace

double texel_solid_angle(int row, int width_px, int height_px) {
  return kTwoPi / static_cast<double>(width_px) * cosine_difference(row, row + 1, height_px);
}

std::array<double, 3> energy_of(const Image& map) {
  std::array<double, 3> energy{};
  for (int y = 0; y < map.height_px; ++y) {
    std::array<double, 3> row{};
    for (int x = 0; x < map.width_px; ++x)
      for (size_t c = 0; c < 3; ++c) row[c] += static_cast<double>(map.pixel(x, y)[c]);
    const double solid_angle = texel_solid_angle(y, map.width_px, map.height_px);
    for (size_t c = 0; c < 3; ++c) energy[c] += solid_angle * row[c];
  }
  return energy;
}

LightStatistics statistics_of(const Image& map) {
  LightStatistics statistics;
  const std::array<double, 3> energy = energy_of(map);
  for (size_t c = 0; c < 3; ++c) statistics.mean[c] = energy[c] / (2 * kTwoPi);
  size_t best = 0;
  for (size_t i = 0; i < map.values.size() / 3; ++i)
    if (const double value = luminance_of(&map.values[3 * i]); value > statistics.peak)
      statistics.peak = value, best = i;
  const auto width = static_cast<size_t>(map.width_px);
  statistics.brightest =
      environment_direction({(static_cast<float>(best % width) + 0.5f) / static_cast<float>(map.width_px),
                             (static_cast<float>(best / width) + 0.5f) / static_cast<float>(map.height_px)});
  return statistics;
}

Image resampled(const Image& map, int width_px) {
  if (width_px == map.width_px && map.width_px == 2 * map.height_px) return map;
  Image result(width_px, width_px / 2, 3);
  parallel_for_each(0, result.height_px, [&](int y) { resample_row(map, y, result); });
  return result;
}

}  // namespace ohb::environments
