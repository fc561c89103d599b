// Light of a latitude-longitude map as integrals over solid angle: texels near the poles count less.
#pragma once

#include <array>

#include "dataset/model/image.h"
#include "dataset/model/vec.h"

namespace ohb::environments {

/// Solid angle in sr of a texel of a row: 2 pi / width x (cos of its upper edge - cos of its lower edge),
/// exact.
double texel_solid_angle(int row, int width_px, int height_px);

/// Integral of radiance over the sphere, a channel each (3 channels): radiance x sr. Summed in row order, so
/// the same bits for any number of threads.
std::array<double, 3> energy_of(const Image& map);

/// Luminance of linear Rec. 709.
inline double luminance_of(const float* rgb) {
  return 0.2126 * static_cast<double>(rgb[0]) + 0.7152 * static_cast<double>(rgb[1]) +
         0.0722 * static_cast<double>(rgb[2]);
}

struct LightStatistics {
  std::array<double, 3> mean{};  // radiance: energy / 4 pi
  double peak = 0;               // largest luminance of a texel
  Vec3f brightest;               // unit direction of its centre: the test pixel
};
LightStatistics statistics_of(const Image& map);

/// The map (2:1, 3 channels) at another width, height = width / 2: each texel is the mean of what it covers,
/// weighted by solid angle. Coarser or finer, the energy of each channel is kept to the rounding of floats.
Image resampled(const Image& map, int width_px);

}  // namespace ohb::environments
