// Errors of regions of an image, from images that differ by their noise alone.
#pragma once

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "renderer/rounds.h"

namespace ohb::renderer {

/// Pixels of a view by region.
struct ErrorRegions {
  std::vector<std::string> names;    // "subject", then classes
  std::vector<size_t> pixels;        // of each
  std::vector<std::vector<int>> of;  // of each pixel: its regions; empty where nothing is seen
};

/// "subject" is every seen pixel of the box; a pixel is of the class that a ray through its middle meets, if
/// that class has at least kLeastRegion_px pixels.
constexpr size_t kLeastRegion_px = 100;
ErrorRegions error_regions(const Picture& picture);

/// Sums over a region's pixels and channels, of one light.
struct RegionSums {
  double square = 0;    // of the expected image
  double variance = 0;  // of the image
  /// Infinite where the noise hides whether there is light at all; 0 where all is black.
  double relative_error() const {
    if (!(variance > 0)) return 0;
    return square > 0 ? std::sqrt(variance / square) : std::numeric_limits<double>::infinity();
  }
};
using RegionTable = std::vector<std::vector<RegionSums>>;  // [light][region]

/// Sums of a function that gives square and variance at one value: value_at(light, index into the image).
template <typename ValueAt>
RegionTable sum_regions(const ErrorRegions& regions, size_t lights, const ValueAt& value_at) {
  RegionTable table(lights, std::vector<RegionSums>(regions.names.size()));
  for (size_t l = 0; l < lights; ++l)
    for (size_t pixel = 0; pixel < regions.of.size(); ++pixel) {
      if (regions.of[pixel].empty()) continue;
      RegionSums here;
      for (size_t c = 0; c < 3; ++c) {
        const RegionSums value = value_at(l, 3 * pixel + c);
        here.square += value.square;
        here.variance += value.variance;
      }
      for (const int region : regions.of[pixel]) {
        table[l][static_cast<size_t>(region)].square += here.square;
        table[l][static_cast<size_t>(region)].variance += here.variance;
      }
    }
  return table;
}

/// The largest of all regions and lights.
double largest_error(const RegionTable& table);

}  // namespace ohb::renderer
