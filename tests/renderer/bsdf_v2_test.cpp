// Principled v2 against quadrature, independent integrals and invariants.
#include "renderer/bsdf_v2.h"

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

PrincipledV2 flat(Vec3f base, float roughness, float f0, Vec3f wo) {
  return {{base, roughness, f0}, {}, {kUp, kUp, kUp, wo}, kUp, true};
}

/// Integral of f cos by midpoints about the mirror direction, where the peak is.
double albedo_by_quadrature(const PrincipledV2& bsdf, Vec3f wo) {
  const Frame frame(normalised({-wo.x, -wo.y, wo.z}));
  constexpr int kTheta = 2000, kPhi = 240;
  double sum = 0;
  for (int i = 0; i < kTheta; ++i) {
    const double s = (i + 0.5) / kTheta, theta = M_PI * s * s, dtheta = M_PI * 2 * s / kTheta;
    for (int j = 0; j < kPhi; ++j) {
      const double phi = 2 * M_PI * (j + 0.5) / kPhi;
      const Vec3f local{static_cast<float>(std::sin(theta) * std::cos(phi)),
                        static_cast<float>(std::sin(theta) * std::sin(phi)),
                        static_cast<float>(std::cos(theta))};
      sum += bsdf.eval(frame.to_world(local)).value.x * std::sin(theta) * dtheta * (2 * M_PI / kPhi);
    }
  }
  return sum;
}

// Mean of what `value` gives for random visible normals, with 5 standard errors; alpha and mu are one cell of
// the tables or lie between them.
template <class Value>
void expect_mean(double expected, double bound, float roughness, float mu, const Value& value) {
  constexpr int kCount = 400000;
  const Vec3f wo{std::sqrt(1 - mu * mu), 0, mu};
  Random random(5, static_cast<uint64_t>(roughness * 1000), static_cast<uint64_t>(mu * 1000));
  double sum = 0, squares = 0;
  for (int i = 0; i < kCount; ++i) {
    const float u1 = random.next(), u2 = random.next();
    const Vec3f h = sample_ggx_visible_normal(wo, roughness * roughness, u1, u2);
    const double v = value(wo, h, 2 * dot(wo, h) * h - wo);
    sum += v;
    squares += v * v;
  }
  const double mean = sum / kCount, error = std::sqrt((squares / kCount - mean * mean) / kCount);
  EXPECT_NEAR(expected, mean, 5 * error + bound) << "roughness " << roughness << " mu " << mu;
}

// 5e-4: the tables' quadrature. The nodes of the grid, so that its interpolation does not count.
TEST(GgxEnergy, EqualsTheMeansOverVisibleNormals) {
  for (const int x : {3, 8, 12, 20, 31})
    for (const int y : {1, 4, 12, 25, 31}) {
      const float roughness = x / 31.0f, mu = y / 31.0f, alpha2 = std::pow(roughness, 4.0f);
      expect_mean(ggx_energy().albedo(roughness, mu), 5e-4, roughness, mu, [&](Vec3f wo, Vec3f, Vec3f wi) {
        const float g1 = 1 + ggx_lambda(wo.z, alpha2);
        return wi.z > 0 ? g1 / (g1 + ggx_lambda(wi.z, alpha2)) : 0.0f;
      });
    }
  for (const int x : {1, 6, 15})
    for (const int y : {1, 7, 15})
      for (const int z : {5, 7, 12}) {
        const float roughness = x / 15.0f, mu = y / 15.0f, root = std::pow(z / 15.0f, 2.0f);
        const float eta = (1 + root) / (1 - root), f0 = root * root;
        expect_mean(ggx_energy().fresnel_share(roughness, mu, z / 15.0f), 5e-4, roughness, mu,
                    [&](Vec3f wo, Vec3f h, Vec3f wi) {
                      const float share = (fresnel_dielectric(dot(wo, h), eta) - f0) / (1 - f0);
                      return wi.z > 0 ? std::max(0.0f, share) : 0.0f;
                    });
      }
}

TEST(GgxEnergy, MeanIsTheIntegralOverCosines) {
  for (int x = 0; x < GgxEnergy::kFine; ++x) {
    const float roughness = x / 31.0f;
    double sum = 0;
    constexpr int kCount = 1000;
    for (int i = 0; i < kCount; ++i) {
      const float mu = (i + 0.5f) / kCount;
      sum += 2 * mu * ggx_energy().albedo(roughness, mu) / kCount;
    }
    EXPECT_NEAR(ggx_energy().mean_albedo(roughness), sum, 1e-3) << roughness;
  }
}

// What a mirror of f0 1 reflects: single scattering loses up to 69 %, made up for to 0.3 % where the
// table's cells are straight.
TEST(PrincipledV2, PerfectReflectorKeepsAllEnergy) {
  for (const float roughness : {.2f, .4f, .7f, 1.f})
    for (const double angle : {0.0, 45.0, 75.0, 85.0}) {
      const Vec3f wo = direction(angle);
      EXPECT_NEAR(albedo_by_quadrature(flat({0, 0, 0}, roughness, 1, wo), wo), 1, 0.01)
          << "roughness " << roughness << " angle " << angle;
    }
}

// White below a layer: nothing is lost and nothing gained, but for what the tables' interpolation and the
// fit of the mean reflectance are off by.
TEST(PrincipledV2, WhiteFurnaceIsWhite) {
  double least = 2, most = 0;
  for (const float f0 : {.02f, .04f, .1f, .3f})
    for (const float roughness : {.1f, .3f, .5f, .8f, 1.f})
      for (const double angle : {0.0, 45.0, 75.0, 85.0}) {
        const Vec3f wo = direction(angle);
        const double albedo = albedo_by_quadrature(flat({1, 1, 1}, roughness, f0, wo), wo);
        least = std::min(least, albedo), most = std::max(most, albedo);
        EXPECT_NEAR(albedo, 1, 0.015) << "f0 " << f0 << " roughness " << roughness << " angle " << angle;
      }
  std::printf("  white furnace: %.4f to %.4f\n", least, most);
}

TEST(PrincipledV2, LambertBelowNothing) {
  for (const double angle : {0.0, 60.0, 85.0}) {
    const Vec3f wo = direction(angle);
    EXPECT_NEAR(albedo_by_quadrature(flat({.6f, 0, 0}, .5f, 0, wo), wo), 0.6, 1e-4);
  }
}

// What walks gets exactly the light that the diffuse lobe loses to it, at any blend.
TEST(PrincipledV2, SubsurfaceTakesItsShareOfWhatIsBelow) {
  const Vec3f wo = direction(50), wi = direction(-20);
  const auto with = [&](float weight, bool walks) {
    return PrincipledV2({{.5f, .5f, .5f}, .4f, .04f}, {weight, walks}, {kUp, kUp, kUp, wo}, kUp, false);
  };
  const float whole = with(0, false).eval(wi).value.x, none = with(1, true).eval(wi).value.x;
  const float below = with(1, true).entry_weight();
  EXPECT_GT(below, 0.9f);
  EXPECT_LT(below, 0.96f);
  EXPECT_NEAR(whole - none, below * .5f * wi.z * kInvPi, 1e-6);
  EXPECT_NEAR(with(.3f, true).entry_weight(), .3f * below, 1e-6);
  EXPECT_NEAR(with(.3f, true).eval(wi).value.x, none + .7f * (whole - none), 1e-6);
  EXPECT_NEAR(with(.3f, false).eval(wi).value.x, whole, 1e-6);  // after a diffuse bounce
  EXPECT_EQ(with(.3f, false).entry_weight(), 0);
}

TEST(PrincipledV2, SampleWeightsAverageToTheAlbedo) {
  constexpr int kCount = 400000;
  for (const float roughness : {.02f, .1f, .25f, .5f, .85f, 1.f})
    for (const double angle : {0.0, 45.0, 75.0, 85.0}) {
      const Vec3f wo = direction(angle);
      const PrincipledV2 bsdf = flat({.8f, .4f, 0}, roughness, .04f, wo);
      const double expected = albedo_by_quadrature(bsdf, wo);
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
      EXPECT_NEAR(mean, expected, 5 * error + 1e-3) << "roughness " << roughness << " angle " << angle;
    }
}

// The directions' pdf with what enters the medium is all there is: integral + entry share + discarded = 1.
TEST(PrincipledV2, SamplerFollowsItsPdf) {
  // Sidak: 0.01 over 32 runs.
  const double limit = 1 - std::pow(1 - 0.01, 1.0 / 32);
  constexpr int kCount = 200000;
  uint64_t seed = 100;
  for (const float roughness : {.1f, .3f, .5f, 1.f})
    for (const double angle : {0.0, 45.0, 80.0, 89.9})
      for (const double tilt : {0.0, 25.0}) {
        const float a = static_cast<float>(tilt * M_PI / 180);
        const Vec3f wo = direction(angle), n{0, std::sin(a), std::cos(a)},
                    valid = cycles::ensure_valid_reflection(kUp, wo, n);
        const PrincipledV2 bsdf({{.8f, .4f, .1f}, roughness, .04f}, {.5f, angle > 60}, {n, kUp, kUp, wo},
                                valid, true);
        // As in v1's test: what is kept below n only when it was sampled is left out on both sides.
        double integral = 0;
        int lost = 0;
        const double p = chi_squared_p_value(
            [&](Random& random, Vec3f& wi) {
              const float u0 = random.next(), u1 = random.next(), u2 = random.next();
              const BsdfSample s = bsdf.sample(u0, u1, u2);
              wi = s.wi;
              const bool kept = s.pdf > 0 && !s.enters && (s.is_diffuse || dot(valid, wi) > 0);
              if (!kept) ++lost;
              return kept;
            },
            [&](Vec3f wi) { return wi.z > 0 ? static_cast<double>(bsdf.eval(wi).pdf) : 0.0; }, kCount, ++seed,
            &integral);
        EXPECT_GT(p, limit) << "roughness " << roughness << " angle " << angle << " tilt " << tilt;
        EXPECT_NEAR(integral + static_cast<double>(lost) / kCount, 1, 0.005);
      }
}

// One bounce between facets is reciprocal; what makes up for the others depends on the viewer alone, as the
// weight of what is below does. So the ratio of both ways is that of the viewers' factors.
TEST(PrincipledV2, SingleScatteringIsReciprocal) {
  Random random(3, 1, 4);
  constexpr float kF0 = .04f;
  const float eta = eta_of_f0(kF0), fit = (eta - 1) / (4.08567f + 1.00071f * eta);
  int tried = 0;
  for (int i = 0; i < 4000; ++i) {
    const auto upper = [&] {
      const float a = random.next(), b = random.next();
      return sample_cosine_hemisphere(a, b);
    };
    const Vec3f a = upper(), b = upper();
    if (a.z < 0.05f || b.z < 0.05f) continue;
    ++tried;
    const float roughness = 0.05f + 0.95f * random.next();
    const float e_mean = ggx_energy().mean_albedo(roughness);
    const auto factor = [&](Vec3f wo) {
      const float e = ggx_energy().albedo(roughness, wo.z);
      return 1 + fit * e_mean / (1 - fit * (1 - e_mean)) * (1 - e) / e;
    };
    const float there = flat({0, 0, 0}, roughness, kF0, a).eval(b).value.x / b.z / factor(a);
    const float back = flat({0, 0, 0}, roughness, kF0, b).eval(a).value.x / a.z / factor(b);
    EXPECT_NEAR(there, back, 2e-4f * std::max(1.0f, there));
  }
  EXPECT_GT(tried, 1000);
}

TEST(PrincipledV2, EightDirectionsAtOnceEqualOneByOne) {
  expect_eight_equal_one_by_one(12, [](const HardPoint& p, Random& random, int trial) {
    return PrincipledV2({{random.next(), random.next(), 0}, p.roughness, p.f0},
                        {trial % 4 ? 0.0f : random.next(), trial % 8 == 0}, {p.n, p.ns, p.ng, p.wo},
                        cycles::ensure_valid_reflection(p.ng, p.wo, p.n), trial % 2 == 0);
  });
}

TEST(PrincipledV2, RoughnessToZeroBecomesAMirrorWithoutNan) {
  for (const float roughness : {0.03f, 0.004f, 0.0037f, 1e-3f, 1e-6f, 0.f})
    for (const double angle : {0.0, 60.0, 89.0, 89.99}) {
      const Vec3f wo = direction(angle);
      const PrincipledV2 bsdf = flat({0, 0, 0}, roughness, .04f, wo);
      Random random(11, 0, 0);
      double sum = 0;
      for (int i = 0; i < 20000; ++i) {
        const float u0 = random.next(), u1 = random.next(), u2 = random.next();
        const BsdfSample s = bsdf.sample(u0, u1, u2);
        ASSERT_TRUE(is_finite(s.value) && std::isfinite(s.pdf)) << roughness;
        if (s.pdf > 0) sum += s.value.x / s.pdf;
      }
      const double fresnel = fresnel_dielectric(wo.z, eta_of_f0(.04f));
      if (angle < 80) {
        EXPECT_NEAR(sum / 20000, fresnel, 0.01 * fresnel + 1e-4) << roughness << " " << angle;
      }
    }
}

// Half of the entries spread by the cosine, half are refracted: into the medium, and towards -n on average.
TEST(PrincipledV2, EntryDirectionsGoIn) {
  const Vec3f wo = direction(70);
  const PrincipledV2 bsdf({{.5f, .5f, .5f}, .4f, .04f}, {1, true}, {kUp, kUp, kUp, wo}, kUp, true);
  Random random(2, 3, 4);
  Vec3f sum{};
  constexpr int kCount = 20000;
  for (int i = 0; i < kCount; ++i) {
    const float u1 = random.next(), u2 = random.next();
    const Vec3f d = bsdf.entry_direction({u1, u2});
    EXPECT_NEAR(length(d), 1, 1e-4);
    if (u1 >= 0.5f) {
      // Snell: the tangential part of wo about the facet shrinks by eta, so none is more than its critical
      // angle (45.6 degrees) off the facet's normal.
      const Vec3f h = normalised(-(wo + cycles::kSkinEntryEta * d));
      EXPECT_GT(dot(h, wo), -1e-3f);
      EXPECT_LT(dot(h, d), -std::sqrt(1 - 1 / (1.4f * 1.4f)) + 1e-3f);
    } else {
      EXPECT_LT(d.z, 0);
    }
    sum += d / kCount;
  }
  EXPECT_LT(sum.z, -0.5f);
  EXPECT_LT(sum.x, 0);  // refracted away from the viewer
  EXPECT_NEAR(sum.y, 0, 0.02);
}

TEST(BumpTerminatorV2, FallsFromOneToZero) {
  const Vec3f n = direction(40);
  EXPECT_EQ(cycles::bump_terminator_v2<float>(kUp, n, direction(91)), 0);
  EXPECT_EQ(cycles::bump_terminator_v2<float>(kUp, n, kUp), 1);
  // G1 of GGX at 60 degrees, alpha^2 = tan(40)^2 / 8 = .08801: 2 / (1 + sqrt(1 + .08801 x 3)).
  EXPECT_NEAR(cycles::bump_terminator_v2<float>(kUp, n, direction(60)), 2 / (1 + std::sqrt(1 + 3 * .0880110)),
              1e-5);
  float previous = 2;
  for (double angle = 1; angle < 90; angle += 1) {
    const float g = cycles::bump_terminator_v2<float>(kUp, n, direction(angle));
    EXPECT_LE(g, previous);
    previous = g;
  }
}

}  // namespace
}  // namespace ohb
