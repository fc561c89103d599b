// Eight numbers at once, for the inner loop that asks a BSDF for several directions.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <experimental/simd>

#include "dataset/model/vec.h"

namespace ohb::renderer {

namespace stdx = std::experimental;

using Float8 = stdx::simd<float, stdx::simd_abi::deduce_t<float, 8>>;
using Mask8 = Float8::mask_type;
using Float4 = stdx::simd<float, stdx::simd_abi::deduce_t<float, 4>>;

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

// One spelling for one number and for eight, so that a formula is written once over its type.
inline float select(bool yes, float a, float b) {
  return yes ? a : b;
}
inline float larger(float a, float b) {
  return std::max(a, b);
}
inline Float8 larger(Float8 a, Float8 b) {
  return stdx::max(a, b);
}
inline float smaller(float a, float b) {
  return std::min(a, b);
}
inline Float8 smaller(Float8 a, Float8 b) {
  return stdx::min(a, b);
}
inline bool any_of(bool yes) {
  return yes;
}
inline bool any_of(Mask8 yes) {
  return stdx::any_of(yes);
}
template <class T>
struct Lanes;
template <>
struct Lanes<float> {
  using Vec3 = Vec3f;
  using Mask = bool;
};
template <>
struct Lanes<Float8> {
  using Vec3 = Vec3f8;
  using Mask = Mask8;
};

inline Vec3f8 select(Mask8 yes, const Vec3f8& a, const Vec3f8& b) {
  return {select(yes, a.x, b.x), select(yes, a.y, b.y), select(yes, a.z, b.z)};
}
inline Vec3f8 to_world(const Frame& frame, const Vec3f8& v) {
  return {v.x * frame.s.x + v.y * frame.t.x + v.z * frame.n.x,
          v.x * frame.s.y + v.y * frame.t.y + v.z * frame.n.y,
          v.x * frame.s.z + v.y * frame.t.z + v.z * frame.n.z};
}

using Int8 = stdx::rebind_simd_t<int32_t, Float8>;

template <class To, class From>
To same_bits(const From& from) {
  static_assert(sizeof(To) == sizeof(From));
  To to;
  std::memcpy(static_cast<void*>(&to), static_cast<const void*>(&from), sizeof(To));
  return to;
}

/// e^x for x from -87 to 88; beyond, as of the limit. Within 2e-7 of the exact value: Cephes' expf.
inline Float8 exp_of(Float8 x) {
  x = stdx::min(stdx::max(x, Float8(-87.0f)), Float8(88.0f));
  const Float8 n = stdx::floor(x * 1.44269504f + 0.5f);
  const Float8 r = x - n * 0.693359375f + n * 2.12194440e-4f;
  Float8 p = 1.9875691500e-4f;
  for (const float next :
       {1.3981999507e-3f, 8.3334519073e-3f, 4.1665795894e-2f, 1.6666665459e-1f, 5.0000001201e-1f})
    p = p * r + next;
  p = p * r * r + r + 1;
  return p * same_bits<Float8>((stdx::static_simd_cast<Int8>(n) + 127) << 23);
}

/// Natural logarithm of a positive normal number. Within 2e-7 of the exact value, relative: Cephes' logf.
inline Float8 log_of(Float8 x) {
  const Int8 bits = same_bits<Int8>(x);
  Float8 exponent = stdx::static_simd_cast<Float8>((bits >> 23) - 126);
  Float8 m = same_bits<Float8>((bits & 0x007fffff) | 0x3f000000);  // in [1/2, 1)
  const Mask8 is_low = m < Float8(0.70710678f);
  exponent = select(is_low, exponent - 1, exponent);
  m = select(is_low, m + m, m) - 1;
  Float8 p = 7.0376836292e-2f;
  for (const float next : {-1.1514610310e-1f, 1.1676998740e-1f, -1.2420140846e-1f, 1.4249322787e-1f,
                           -1.6668057665e-1f, 2.0000714765e-1f, -2.4999993993e-1f, 3.3333331174e-1f})
    p = p * m + next;
  p = p * m * m * m - exponent * 2.12194440e-4f - 0.5f * m * m;
  return m + p + exponent * 0.693359375f;
}

/// sine_cosine_of_turns (sampling.h) of turns in [0, 1).
inline void sine_cosine_of_turns(Float8 turns, Float8& sine, Float8& cosine) {
  const Float8 quarter = stdx::floor(4 * turns + 0.5f);  // 0 to 4
  const Float8 a = 6.28318531f * (turns - 0.25f * quarter), a2 = a * a;
  const Float8 s = a * (1 + a2 * (-1.0f / 6 + a2 * (1.0f / 120 + a2 * (-1.0f / 5040))));
  const Float8 c = 1 + a2 * (-0.5f + a2 * (1.0f / 24 + a2 * (-1.0f / 720 + a2 * (1.0f / 40320))));
  const Mask8 is_odd = quarter == Float8(1) || quarter == Float8(3);
  sine = select(is_odd, c, s), cosine = select(is_odd, s, c);
  sine = select(quarter == Float8(2) || quarter == Float8(3), -sine, sine);
  cosine = select(quarter == Float8(1) || quarter == Float8(2), -cosine, cosine);
}

}  // namespace ohb::renderer
