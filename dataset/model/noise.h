// Procedural noise with the same bits everywhere.
#pragma once

#include <algorithm>
#include <cmath>

#include "dataset/model/sampling.h"
#include "dataset/model/vec.h"

namespace ohb {

/// 0 below `low`, 1 above `high`, smooth in between.
inline float smooth(float low, float high, float x) {
  const float t = std::clamp((x - low) / (high - low), 0.0f, 1.0f);
  return t * t * (3 - 2 * t);
}

/// 64 random bits of a cell of the integer lattice.
inline uint64_t cell_key(int x, int y, int z, uint64_t which) {
  const uint64_t key = static_cast<uint64_t>(static_cast<uint32_t>(x)) * 73856093u ^
                       static_cast<uint64_t>(static_cast<uint32_t>(y)) * 19349663u ^
                       static_cast<uint64_t>(static_cast<uint32_t>(z)) * 83492791u;
  return mix_bits(key + which * 0x51ed27u + 0x9e3779b97f4a7c15ull);
}

/// The same as a number in [0, 1).
inline float cell_number(int x, int y, int z, uint64_t which) {
  return static_cast<float>(cell_key(x, y, z, which) >> 40) * 0x1p-24f;
}

/// Smooth noise in [0, 1) of period 1.
inline float value_noise(Vec3f p, uint64_t which) {
  const int x = static_cast<int>(std::floor(p.x)), y = static_cast<int>(std::floor(p.y)),
            z = static_cast<int>(std::floor(p.z));
  const float s = smooth(0, 1, p.x - static_cast<float>(x)), t = smooth(0, 1, p.y - static_cast<float>(y)),
              u = smooth(0, 1, p.z - static_cast<float>(z));
  float sum = 0;
  for (int k = 0; k < 8; ++k)
    sum += (k & 1 ? s : 1 - s) * (k & 2 ? t : 1 - t) * (k & 4 ? u : 1 - u) *
           cell_number(x + (k & 1), y + (k >> 1 & 1), z + (k >> 2), which);
  return sum;
}

}  // namespace ohb
