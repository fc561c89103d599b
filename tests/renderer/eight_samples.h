// Eight directions of a BSDF at once against one after the other.
#pragma once

#include <gtest/gtest.h>

#include "renderer/bsdf.h"

namespace ohb {
using namespace renderer;

/// Tilted normals, every lobe; roughness down to where alpha is rounded away.
struct HardPoint {
  Vec3f n, ns, ng, wo;
  float roughness, f0;
};

inline Vec3f random_direction(Random& random) {
  return normalised(Vec3f{random.next() - 0.5f, random.next() - 0.5f, random.next() - 0.5f});
}

inline HardPoint hard_point(int trial, Random& random) {
  HardPoint p;
  p.ng = random_direction(random), p.wo = random_direction(random);
  if (dot(p.wo, p.ng) < 0) p.wo = -p.wo;
  p.ns = trial % 3 ? normalised(p.ng + 0.3f * random_direction(random)) : p.ng;
  p.n = trial % 2 ? normalised(p.ns + 0.7f * random_direction(random)) : p.ns;
  p.roughness = trial % 5 ? random.next() : 0.01f * random.next();
  p.f0 = trial % 7 ? 0.08f * random.next() : 0;
  return p;
}

/// Near the mirrored direction, grazing and hidden ones.
template <class Bsdf>
void expect_values_equal_one_by_one(const Bsdf& bsdf, const HardPoint& p, Random& random) {
  // Rounding of h decides at grazing peaks: alpha = 1e-4 there turns 1e-7 into parts of a thousand.
  const float rounding = 2e-5f + 2e-7f / (p.roughness * p.roughness * p.roughness * p.roughness + 1e-6f);
  Vec3f wi[8];
  Vec3f8 eight;
  for (int k = 0; k < 8; ++k) {
    wi[k] = random_direction(random);
    if (k < 2) wi[k] = normalised(2 * dot(p.n, p.wo) * p.n - p.wo + 0.01f * static_cast<float>(k) * wi[k]);
    eight.x[k] = wi[k].x, eight.y[k] = wi[k].y, eight.z[k] = wi[k].z;
  }
  const BsdfValue8 values = bsdf.eval(eight);
  for (int k = 0; k < 8; ++k) {
    const BsdfValue one = bsdf.eval(wi[k]);
    EXPECT_NEAR(values.value.x[k], one.value.x, rounding * (one.value.x + 1e-3f));
    EXPECT_NEAR(values.value.y[k], one.value.y, rounding * (one.value.y + 1e-3f));
    EXPECT_NEAR(values.value.z[k], one.value.z, rounding * (one.value.z + 1e-3f));
    EXPECT_NEAR(values.pdf[k], one.pdf, rounding * (one.pdf + 1e-3f));
  }
}

/// The numbers of samples that were compared whole, and that one way refuses and the other does not: at a
/// border rounding decides.
struct Compared {
  int whole = 0, refused_by_one = 0;
};

template <class Bsdf>
void expect_samples_equal_one_by_one(const Bsdf& bsdf, const HardPoint& p, Random& random,
                                     Compared& compared) {
  float lobes[8];
  Vec2f u[8];
  BsdfSample samples[8];
  for (int k = 0; k < 8; ++k) lobes[k] = random.next(), u[k] = random.next_pair();
  const int count = 1 + static_cast<int>(8 * random.next());
  bsdf.sample(count, lobes, u, samples);
  // The direction's own rounding, seen by a narrow highlight.
  const float tolerance = 5e-3f + 4e-6f / (p.roughness * p.roughness + 1e-6f);
  for (int k = 0; k < count; ++k) {
    const BsdfSample one = bsdf.sample(lobes[k], u[k].x, u[k].y);
    EXPECT_EQ(samples[k].enters, one.enters);
    if (one.enters) {
      EXPECT_EQ(samples[k].pdf, one.pdf);
      continue;
    }
    compared.refused_by_one += (one.pdf > 0) != (samples[k].pdf > 0);
    if (!(one.pdf > 0 && samples[k].pdf > 0)) continue;
    ++compared.whole;
    EXPECT_EQ(samples[k].is_diffuse, one.is_diffuse);
    EXPECT_LT(length(samples[k].wi - one.wi), 2e-5f);
    EXPECT_NEAR(samples[k].pdf, one.pdf, tolerance * one.pdf + 1e-3f);
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(samples[k].value[c] / samples[k].pdf, one.value[c] / one.pdf,
                  tolerance * (one.value[c] / one.pdf) + 1e-3f);
  }
}

/// eval() and sample() of the BSDFs that `make(point, random, trial)` makes.
template <class Make>
void expect_eight_equal_one_by_one(uint64_t seed, const Make& make) {
  constexpr int kTrials = 3000;
  Random random(seed, 0, 0);
  Compared compared;
  for (int trial = 0; trial < kTrials; ++trial) {
    SCOPED_TRACE(trial);
    const HardPoint p = hard_point(trial, random);
    const auto bsdf = make(p, random, trial);
    expect_values_equal_one_by_one(bsdf, p, random);
    expect_samples_equal_one_by_one(bsdf, p, random, compared);
  }
  EXPECT_GT(compared.whole, kTrials);
  EXPECT_LT(compared.refused_by_one, kTrials / 300);
}

}  // namespace ohb
