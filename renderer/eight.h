// Eight numbers at once, for the inner loop that asks a BSDF for several directions.
#pragma once

#include <experimental/simd>

#include "dataset/model/vec.h"

namespace ohb {

namespace stdx = std::experimental;

using Float8 = stdx::simd<float, stdx::simd_abi::deduce_t<float, 8>>;
using Mask8 = Float8::mask_type;

struct Vec3f8 {
  Float8 x, y, z;
};

inline Float8 dot(Vec3f a, const Vec3f8& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Float8 dot(const Vec3f8& a, const Vec3f8& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vec3f8 cross(Vec3f a, const Vec3f8& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// a where `yes`, else b.
inline Float8 select(Mask8 yes, Float8 a, Float8 b) {
  stdx::where(yes, b) = a;
  return b;
}

}  // namespace ohb
