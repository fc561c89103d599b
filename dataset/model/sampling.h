// Random numbers and warps. Every warp states its pdf, in the measure that it names.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "dataset/model/mix_bits.h"
#include "dataset/model/vec.h"

namespace ohb {

constexpr float kPi = 3.14159265358979323846f;
constexpr float kInvPi = 1.0f / kPi;

/// PCG-XSH-RR 64/32 (O'Neill 2014), seeded by what is drawn: (seed, pixel, sample), never by time or thread.
class Random {
 public:
  Random(uint64_t seed, uint64_t pixel, uint64_t sample)
      : state_(mix_bits(mix_bits(mix_bits(seed + 0x9e3779b97f4a7c15ull) ^ pixel) +
                        0x9e3779b97f4a7c15ull * (sample + 1))),
        increment_(mix_bits(state_ ^ pixel) | 1) {}
  uint32_t next_bits() {
    const uint64_t old = state_;
    state_ = old * 6364136223846793005ull + increment_;
    const uint32_t shifted = static_cast<uint32_t>(((old >> 18) ^ old) >> 27);
    const uint32_t turn = static_cast<uint32_t>(old >> 59);
    return (shifted >> turn) | (shifted << ((32 - turn) & 31));
  }
  /// Uniform in [0, 1).
  float next() { return static_cast<float>(next_bits() >> 8) * 0x1p-24f; }
  Vec2f next_pair() {
    const float x = next();
    return {x, next()};
  }
  /// Number k of as many independent others as are wanted.
  Random branch(uint64_t k) const {
    Random other = *this;
    other.state_ = mix_bits(state_ + 0x9e3779b97f4a7c15ull * (k + 1));
    other.increment_ = mix_bits(other.state_ ^ increment_) | 1;
    return other;
  }

 private:
  uint64_t state_, increment_;
};

/// The first 32 bits of x in reverse order.
inline uint32_t reverse_bits(uint32_t x) {
  x = __builtin_bswap32(x);
  x = ((x & 0x0f0f0f0fu) << 4) | ((x >> 4) & 0x0f0f0f0fu);
  x = ((x & 0x33333333u) << 2) | ((x >> 2) & 0x33333333u);
  return ((x & 0x55555555u) << 1) | ((x >> 1) & 0x55555555u);
}

/// Owen scrambling of a 32-bit fraction, by the permutation of Laine and Karras as Burley uses it ("Practical
/// Hash-based Owen Scrambling", JCGT 2020, section 3).
inline uint32_t owen_scramble(uint32_t x, uint32_t seed) {
  x = reverse_bits(x);
  x += seed;
  x ^= x * 0x6c50b47cu;
  x ^= x * 0xb82f1e52u;
  x ^= x * 0xc7afe638u;
  x ^= x * 0x8d22f6e6u;
  return reverse_bits(x);
}

/// Point `index` of Sobol's first two dimensions, as 32-bit fractions. The second dimension's generator is
/// Pascal's triangle modulo 2: digit r is the exclusive or of the index bits j that contain r.
inline void sobol_pair(uint32_t index, uint32_t& x, uint32_t& y) {
  x = reverse_bits(index);
  index ^= (index & 0xaaaaaaaau) >> 1;
  index ^= (index & 0xccccccccu) >> 2;
  index ^= (index & 0xf0f0f0f0u) >> 4;
  index ^= (index & 0xff00ff00u) >> 8;
  index ^= (index & 0xffff0000u) >> 16;
  y = reverse_bits(index);
}

/// The numbers of one path. The leading pairs (pixel position, then lights, lobe and direction at the first
/// surface, and what walks under it begin and end with) are Owen-scrambled Sobol points, shuffled pair by
/// pair (Burley 2020, padding): the samples of a pixel are stratified there. Everything after them is
/// independent.
class PathSampler {
 public:
  static constexpr int kStratifiedPairs = 8;

  PathSampler(uint64_t seed, uint64_t pixel, uint32_t sample)
      : random(seed, pixel, sample),
        key_(mix_bits(mix_bits(seed ^ 0x2545f4914f6cdd1dull) ^ pixel)),
        sample_(sample) {}

  Vec2f next_pair() {
    if (pair_ >= kStratifiedPairs) return random.next_pair();
    const uint64_t bits = mix_bits(key_ + 0x9e3779b97f4a7c15ull * static_cast<uint64_t>(++pair_));
    const uint64_t more = mix_bits(bits);
    uint32_t x, y;
    sobol_pair(owen_scramble(sample_, static_cast<uint32_t>(bits)), x, y);
    return {fraction(owen_scramble(x, static_cast<uint32_t>(bits >> 32))),
            fraction(owen_scramble(y, static_cast<uint32_t>(more)))};
  }

  Random random;

 private:
  static float fraction(uint32_t bits) { return static_cast<float>(bits >> 8) * 0x1p-24f; }

  uint64_t key_;
  uint32_t sample_;
  int pair_ = 0;
};

constexpr float kLatticeStep = 0.61803399f;  // golden section: a lattice of any size is even

inline float fraction_of(float x) {
  return x - std::floor(x);
}

/// Sine and cosine of a number of turns, |turns| < 2^20: Taylor polynomials on an eighth of a turn, within
/// 2e-7 of the exact values.
struct SineCosine {
  float sine, cosine;
};
inline SineCosine sine_cosine_of_turns(float turns) {
  const float quarter = std::nearbyint(4 * turns);
  const float a = 2 * kPi * (turns - 0.25f * quarter), a2 = a * a;
  const float s = a * (1 + a2 * (-1.0f / 6 + a2 * (1.0f / 120 + a2 * (-1.0f / 5040))));
  const float c = 1 + a2 * (-0.5f + a2 * (1.0f / 24 + a2 * (-1.0f / 720 + a2 * (1.0f / 40320))));
  const int q = static_cast<int>(quarter) & 3;
  const float sine = (q & 1) ? c : s, cosine = (q & 1) ? s : c;
  return {(q & 2) ? -sine : sine, (q == 1 || q == 2) ? -cosine : cosine};
}

/// The angle of (x, y) from the x axis in turns, in [-0.5, 0.5]; 0 of (0, 0). Abramowitz and Stegun 4.4.49:
/// within 1e-7 of the exact value.
inline float turns_of(float y, float x) {
  const float ax = std::fabs(x), ay = std::fabs(y);
  const float high = std::max(ax, ay), low = std::min(ax, ay);
  const float t = high > 0 ? low / high : 0, t2 = t * t;
  float p = -0.0161657367f + 0.0028662257f * t2;
  p = 0.0429096138f + p * t2;
  p = -0.0752896400f + p * t2;
  p = 0.1065626393f + p * t2;
  p = -0.1420889944f + p * t2;
  p = 0.1999355085f + p * t2;
  p = -0.3333314528f + p * t2;
  float turns = (t + t * t2 * p) * (0.5f * kInvPi);
  if (ay > ax) turns = 0.25f - turns;
  if (x < 0) turns = 0.5f - turns;
  return y < 0 ? -turns : turns;
}

/// A point of the unit disk, uniform (polar; u1 = 0 is the centre). pdf 1 / pi in area.
inline Vec2f sample_disk(float u1, float u2) {
  const float radius = std::sqrt(u1);
  const SineCosine phi = sine_cosine_of_turns(u2);
  return {radius * phi.cosine, radius * phi.sine};
}

/// In (-1, 1) with pdf 1 - |x|, monotone in u.
inline float sample_tent(float u) {
  return u < 0.5f ? std::sqrt(2 * u) - 1 : 1 - std::sqrt(2 - 2 * u);
}

/// A direction about +Z, pdf cos(theta) / pi in solid angle.
inline Vec3f sample_cosine_hemisphere(float u1, float u2) {
  const Vec2f d = sample_disk(u1, u2);
  return {d.x, d.y, std::sqrt(std::max(0.0f, 1 - u1))};
}

/// What sample_ggx_visible_normal() makes of its view.
struct GgxView {
  Vec3f v, t1, t2;
  float blend;
  GgxView(Vec3f wo, float alpha) : v(normalised({alpha * wo.x, alpha * wo.y, wo.z})) {
    const float length2 = v.x * v.x + v.y * v.y;
    t1 = length2 > 0 ? Vec3f{-v.y, v.x, 0} / std::sqrt(length2) : Vec3f{1, 0, 0};
    t2 = cross(v, t1);
    blend = 0.5f * (1 + v.z);
  }
};

/// A GGX normal visible from `wo` (local, wo.z > 0), isotropic width alpha. Heitz, "Sampling the GGX
/// Distribution of Visible Normals", JCGT 2018, with pdf G1(wo) max(0, wo.h) D(h) / wo.z in solid angle of h.
inline Vec3f sample_ggx_visible_normal(Vec3f wo, float alpha, float u1, float u2) {
  const GgxView view(wo, alpha);
  Vec2f p = sample_disk(u1, u2);
  p.y = (1 - view.blend) * std::sqrt(std::max(0.0f, 1 - p.x * p.x)) + view.blend * p.y;
  const Vec3f h = p.x * view.t1 + p.y * view.t2 + std::sqrt(std::max(0.0f, 1 - dot(p, p))) * view.v;
  return normalised({alpha * h.x, alpha * h.y, std::max(1e-6f, h.z)});
}

/// Power heuristic with exponent 2 (Veach 1997, section 9.2): the weight of the strategy with pdf `a`.
inline float power_heuristic(float a, float b) {
  // Ratios instead of squares: a pdf of 1e25 must not overflow.
  if (a <= 0) return 0;
  const float ratio = b / a;
  return 1 / (1 + ratio * ratio);
}

}  // namespace ohb
