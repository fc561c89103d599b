// sRGB transfer functions (IEC 61966-2-1), piecewise, not a power of 2.2.
#pragma once

#include <cmath>

namespace ohb {

/// Encoded [0,1] to linear [0,1]; continues beyond the range.
inline float srgb_to_linear(float c) {
  return c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f);
}
/// Linear to encoded, inverse of srgb_to_linear.
inline float linear_to_srgb(float c) {
  return c <= 0.0031308f ? c * 12.92f : 1.055f * std::pow(c, 1.0f / 2.4f) - 0.055f;
}

}  // namespace ohb
