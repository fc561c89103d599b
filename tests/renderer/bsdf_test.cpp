// Principled v1 against quadrature, the furnace values measured in Cycles 3.4.1, and invariants.
#include "renderer/bsdf.h"

#include <gtest/gtest.h>

#include "chi_squared.h"
#include "eight_samples.h"

namespace ohb {
using namespace renderer;
namespace {

constexpr Vec3f kUp{0, 0, 1};

Vec3f direction(double angle_deg) {
  const double a = angle_deg * M_PI / 180;
  return {static_cast<float>(std::sin(a)), 0, static_cast<float>(std::cos(a))};
}

PrincipledV1 flat(Vec3f base, float roughness, float blender_specular, Vec3f wo) {
  return {{base, roughness, cycles::kF0PerSpecular * blender_specular}, {kUp, kUp, kUp, wo}, true};
}

// Integral of f cos over the hemisphere about the mirror direction's pole, where the peak is.
Vec3f albedo_by_quadrature(const PrincipledV1& bsdf, Vec3f wo) {
  const Frame frame(normalised({-wo.x, -wo.y, wo.z}));
  constexpr int kTheta = 2000, kPhi = 240;
  double sum[3] = {};
  for (int i = 0; i < kTheta; ++i) {
    // Squared spacing puts most nodes near the peak.
    const double s = (i + 0.5) / kTheta, theta = M_PI * s * s, dtheta = M_PI * 2 * s / kTheta;
    for (int j = 0; j < kPhi; ++j) {
      const double phi = 2 * M_PI * (j + 0.5) / kPhi;
      const Vec3f local{static_cast<float>(std::sin(theta) * std::cos(phi)),
                        static_cast<float>(std::sin(theta) * std::sin(phi)),
                        static_cast<float>(std::cos(theta))};
      const Vec3f value = bsdf.eval(frame.to_world(local)).value;
      for (int c = 0; c < 3; ++c) sum[c] += value[c] * std::sin(theta) * dtheta * (2 * M_PI / kPhi);
    }
  }
  return {static_cast<float>(sum[0]), static_cast<float>(sum[1]), static_cast<float>(sum[2])};
}

struct Furnace {
  float specular, roughness;
  double angle_deg;
  float red, blue;  // base .8 and 0; negative: not measured
};

// Cycles 3.4.1, constant environment 1, base (.8, .4, 0); Monte Carlo noise up to 2.8e-4.
const Furnace kGolden[] = {
    {.5f, .1f, 0, .8258f, .0400f},  {.5f, .1f, 85, 1.1873f, .5985f}, {.5f, .5f, 0, .8419f, .0370f},
    {.5f, .5f, 75, .9315f, .1137f}, {.5f, 1.f, 0, .8413f, .0127f},   {.5f, 1.f, 85, 1.1608f, .0404f},
    {0.f, .5f, 0, .8048f, -1},      {0.f, .5f, 85, .8179f, -1},      {0.f, 1.f, 85, 1.1205f, -1}};

TEST(PrincipledV1, FurnaceEqualsCycles) {
  for (const Furnace& golden : kGolden) {
    const Vec3f wo = direction(golden.angle_deg);
    const Vec3f albedo = albedo_by_quadrature(flat({.8f, .4f, 0}, golden.roughness, golden.specular, wo), wo);
    EXPECT_NEAR(albedo.x, golden.red, 5e-4)
        << "roughness " << golden.roughness << " angle " << golden.angle_deg;
    if (golden.blue >= 0) {
      EXPECT_NEAR(albedo.z, golden.blue, 5e-4) << "roughness " << golden.roughness;
    }
  }
}

TEST(PrincipledV1, SampleWeightsAverageToTheAlbedo) {
  constexpr int kCount = 400000;
  for (const float roughness : {.02f, .1f, .25f, .5f, .85f, 1.f})
    for (const double angle : {0.0, 45.0, 75.0, 85.0}) {
      const Vec3f wo = direction(angle);
      const PrincipledV1 bsdf = flat({.8f, .4f, 0}, roughness, .5f, wo);
      const Vec3f expected = albedo_by_quadrature(bsdf, wo);
      Random random(7, static_cast<uint64_t>(roughness * 1000), static_cast<uint64_t>(angle));
      double sum = 0, squares = 0;
      for (int i = 0; i < kCount; ++i) {
        const float u0 = random.next(), u1 = random.next(), u2 = random.next();
        const BsdfSample s = bsdf.sample(u0, u1, u2);
        const double w = s.pdf > 0 ? s.value.x / s.pdf : 0;
        sum += w;
        squares += w * w;
      }
      const double mean = sum / kCount, error = std::sqrt((squares / kCount - mean * mean) / kCount);
      // 5 standard errors: 24 cases, false alarm 1.4e-5; 1e-3 is the quadrature's own error at roughness .02.
      EXPECT_NEAR(mean, expected.x, 5 * error + 1e-3) << "roughness " << roughness << " angle " << angle;
    }
}

TEST(PrincipledV1, SamplerFollowsItsPdf) {
  // Sidak: 0.01 over 32 runs.
  const double limit = 1 - std::pow(1 - 0.01, 1.0 / 32);
  uint64_t seed = 100;
  for (const float roughness : {.1f, .3f, .5f, 1.f})
    for (const double angle : {0.0, 45.0, 80.0, 89.9})
      for (const double tilt : {0.0, 25.0}) {
        const Vec3f wo = direction(angle),
                    n = tilt == 0 ? kUp
                                  : normalised(Vec3f{0, static_cast<float>(std::sin(tilt * M_PI / 180)),
                                                     static_cast<float>(std::cos(tilt * M_PI / 180))});
        if (!(dot(n, wo) > 1e-4f)) continue;
        const PrincipledV1 bsdf({{.8f, .4f, .1f}, roughness, .04f}, {n, kUp, kUp, wo}, true);
        // The part that Cycles discards (below the surface, ng . wi <= 0) is a bin of its own, left out on
        // both sides; so is what it keeps below n and only when it was sampled (n . wi <= 0).
        const double p = chi_squared_p_value(
            [&](Random& random, Vec3f& wi) {
              const float u0 = random.next(), u1 = random.next(), u2 = random.next();
              const BsdfSample s = bsdf.sample(u0, u1, u2);
              wi = s.wi;
              return s.pdf > 0 && dot(n, wi) > 0;
            },
            [&](Vec3f wi) { return wi.z > 0 ? static_cast<double>(bsdf.eval(wi).pdf) : 0.0; }, 400000,
            ++seed);
        EXPECT_GT(p, limit) << "roughness " << roughness << " angle " << angle << " tilt " << tilt;
      }
}

TEST(PrincipledV1, IsReciprocal) {
  Random random(3, 1, 4);
  for (int i = 0; i < 2000; ++i) {
    const auto upper = [&] {
      const float a = random.next(), b = random.next();
      return sample_cosine_hemisphere(a, b);
    };
    const Vec3f a = upper(), b = upper();
    if (a.z < 0.01f || b.z < 0.01f) continue;
    const float roughness = 0.05f + 0.95f * random.next();
    const Vec3f there = flat({.8f, .4f, 0}, roughness, .5f, a).eval(b).value * (1 / b.z);
    const Vec3f back = flat({.8f, .4f, 0}, roughness, .5f, b).eval(a).value * (1 / a.z);
    EXPECT_NEAR(there.x, back.x, 2e-4f * std::max(1.0f, there.x));
    EXPECT_NEAR(there.z, back.z, 2e-4f * std::max(1.0f, there.z));
  }
}

TEST(PrincipledV1, EightDirectionsAtOnceEqualOneByOne) {
  expect_eight_equal_one_by_one(11, [](const HardPoint& p, Random& random, int trial) {
    return PrincipledV1({{random.next(), random.next(), 0}, p.roughness, p.f0}, {p.n, p.ns, p.ng, p.wo},
                        trial % 2 == 0, static_cast<DiffuseLobe>(trial % 4 % 3));
  });
}

TEST(PrincipledV1, RoughnessToZeroBecomesAMirrorWithoutNan) {
  for (const float roughness : {0.03f, 0.018f, 0.0178f, 0.01f, 1e-3f, 1e-6f, 0.f})
    for (const double angle : {0.0, 60.0, 89.0, 89.99}) {
      const Vec3f wo = direction(angle);
      const PrincipledV1 bsdf = flat({0, 0, 0}, roughness, .5f, wo);
      Random random(11, 0, 0);
      double sum = 0;
      for (int i = 0; i < 20000; ++i) {
        const float u0 = random.next(), u1 = random.next(), u2 = random.next();
        const BsdfSample s = bsdf.sample(u0, u1, u2);
        ASSERT_TRUE(is_finite(s.value) && std::isfinite(s.pdf)) << roughness;
        if (s.pdf > 0) sum += s.value.x / s.pdf;
      }
      // A smooth mirror reflects the Fresnel reflectance; masking of a slightly rough one takes a little at
      // grazing.
      const double fresnel = fresnel_dielectric(wo.z, eta_of_f0(.04f));
      if (angle < 80) {
        EXPECT_NEAR(sum / 20000, fresnel, 0.01 * fresnel + 1e-4) << roughness << " " << angle;
      }
    }
}

TEST(EnsureValidReflection, MirrorDirectionLeavesTheSurface) {
  Random random(5, 5, 5);
  int changed = 0;
  for (int i = 0; i < 100000; ++i) {
    const float a = random.next(), b = random.next(), c = random.next(), d = random.next();
    const Vec3f wo = sample_cosine_hemisphere(a, b), n = sample_cosine_hemisphere(c, d);
    if (wo.z < 1e-4f) continue;
    const Vec3f m = cycles::ensure_valid_reflection(kUp, wo, n);
    const float limit = std::min(0.9f * wo.z, 0.01f);
    const Vec3f mirror = 2 * dot(m, wo) * m - wo;
    EXPECT_GE(mirror.z, limit - 2e-4f);
    EXPECT_NEAR(length(m), 1, 1e-4);
    if (m.z != n.z) {
      ++changed;
      EXPECT_GE(m.z, n.z - 1e-5f);
      EXPECT_NEAR(mirror.z, limit, 2e-4f);
    }
  }
  EXPECT_GT(changed, 1000);
}

TEST(EnsureValidReflection, MeasuredTilt) {
  // Measured in Cycles 3.4.1: a 40 degree tilt seen from -15 degrees becomes 37.2 degrees.
  const double tilt = 40 * M_PI / 180;
  const Vec3f n{static_cast<float>(std::sin(tilt)), 0, static_cast<float>(std::cos(tilt))};
  const Vec3f m = cycles::ensure_valid_reflection(kUp, direction(-15), n);
  EXPECT_NEAR(std::acos(m.z) * 180 / M_PI, 37.2, 0.05);
}

TEST(BumpTerminator, IsOneAtFullLightAndZeroBelow) {
  const Vec3f n = direction(40);
  EXPECT_EQ(cycles::bump_terminator<float>(kUp, n, direction(91)), 0);
  EXPECT_EQ(cycles::bump_terminator<float>(kUp, n, kUp), 1);
  // Cubic between: g = .5 gives -g^3 + g^2 + g = .625. cos(a) = .5 cos(40) cos(a - 40) solved for a.
  const double tilt = 40 * M_PI / 180;
  const double half = std::atan((2 / std::cos(tilt) - std::cos(tilt)) / std::sin(tilt)) * 180 / M_PI;
  EXPECT_NEAR(cycles::bump_terminator<float>(kUp, n, direction(half)), .625f, 1e-5f);
  float previous = 2;
  for (double angle = 40; angle < 90; angle += 1) {
    const float g = cycles::bump_terminator<float>(kUp, n, direction(angle));
    EXPECT_LE(g, previous + 1e-6f);
    previous = g;
  }
}

}  // namespace
}  // namespace ohb
