// Eight samples of a BSDF at once against one after the other.
#pragma once

#include <gtest/gtest.h>

#include "renderer/bsdf.h"

namespace ohb {

/// Relative: rounding of h decides at grazing peaks; alpha = 1e-4 there turns 1e-7 into parts of a thousand.
inline float rounding_of(float roughness) {
  return 2e-5f + 2e-7f / (roughness * roughness * roughness * roughness + 1e-6f);
}

template <class Bsdf>
void expect_samples_equal_one_by_one(const Bsdf& bsdf, float roughness, Random& random) {
  float lobes[8];
  Vec2f u[8];
  BsdfSample samples[8];
  for (int k = 0; k < 8; ++k) lobes[k] = random.next(), u[k] = random.next_pair();
  const int count = 1 + static_cast<int>(8 * random.next());
  bsdf.sample(count, lobes, u, samples);
  for (int k = 0; k < count; ++k) {
    const BsdfSample one = bsdf.sample(lobes[k], u[k].x, u[k].y);
    EXPECT_EQ(samples[k].enters, one.enters);
    // At a border rounding decides.
    if (one.enters || (one.pdf > 0) != (samples[k].pdf > 0)) continue;
    EXPECT_EQ(samples[k].is_diffuse, one.is_diffuse);
    if (!(one.pdf > 0)) continue;
    EXPECT_LT(length(samples[k].wi - one.wi), 2e-5f);
    // The direction's own rounding, seen by a narrow highlight.
    const float alpha = roughness * roughness, tolerance = 5e-3f + 4e-6f / (alpha + 1e-6f);
    EXPECT_NEAR(samples[k].pdf, one.pdf, tolerance * one.pdf + 1e-3f);
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(samples[k].value[c] / samples[k].pdf, one.value[c] / one.pdf,
                  tolerance * (one.value[c] / one.pdf) + 1e-3f);
  }
}

}  // namespace ohb
