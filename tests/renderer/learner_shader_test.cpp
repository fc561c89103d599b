// The learner's shader (learner/shading.h) against the renderer's BSDF, which Cycles pins: lobe by lobe, at
// oblique normals and lights.
#include <gtest/gtest.h>

#include "learner/shading.h"
#include "renderer/bsdf.h"

namespace ohb {
namespace {

struct Lobes {
  double diffuse = 0, highlight = 0;  // f times the cosine: of albedo 1, and of F0 1
};

/// The viewer looks along -Z, as the learner's camera does.
Lobes of_learner(Vec3f n, Vec3f wi, float roughness) {
  using namespace learner::shading;
  const Surface<double> surface{0, 0, 0, n.x, n.y, n.z, 1, 0, 0, roughness, 1, 0};
  const Reflection<double> r = reflect(surface, Light<double>{wi.x, wi.y, wi.z, 1});
  return {(r.out0 - r.out1) / r.irradiance, r.out1 / r.irradiance};
}

Lobes of_renderer(Vec3f n, Vec3f wi, float roughness) {
  const renderer::ShadingFrame frame{n, n, n, {0, 0, 1}};
  renderer::Reflectance white, mirroring;
  white.base = {1, 1, 1}, white.f0 = 0, white.roughness = roughness;
  mirroring.base = {0, 0, 0}, mirroring.f0 = 1, mirroring.roughness = roughness;
  return {renderer::PrincipledV1(white, frame, false).eval(wi).value.x,
          renderer::PrincipledV1(mirroring, frame, false).eval(wi).value.x};
}

Vec3f towards(double from_z_degrees, double turn_degrees) {
  const double a = from_z_degrees * M_PI / 180, b = turn_degrees * M_PI / 180;
  return {static_cast<float>(std::sin(a) * std::cos(b)), static_cast<float>(std::sin(a) * std::sin(b)),
          static_cast<float>(std::cos(a))};
}

TEST(LearnerShader, HasTheRenderersLobesAtObliqueAngles) {
  int lit = 0;
  for (const float roughness : {0.25f, 0.4f, 0.85f})
    for (const double tilt : {0.0, 35.0, 60.0, 78.0})
      for (const double from_z : {10.0, 50.0, 85.0})
        for (const double turn : {0.0, 45.0, 110.0, 180.0}) {
          const Vec3f n = towards(tilt, 0), wi = towards(from_z, turn);
          if (dot(n, wi) < 0.02f) continue;
          ++lit;
          const Lobes mine = of_learner(n, wi, roughness), theirs = of_renderer(n, wi, roughness);
          SCOPED_TRACE(testing::Message() << "roughness " << roughness << ", normal at " << tilt
                                          << " degrees, light at " << from_z << ", turned by " << turn);
          // Both compute the same formulas, one in double and one in float: rounding alone.
          EXPECT_NEAR(mine.diffuse, theirs.diffuse, 1e-5 * theirs.diffuse + 1e-7);
          // eta_of_f0 stops at F0 = 0.9999.
          EXPECT_NEAR(mine.highlight, theirs.highlight, 3e-4 * theirs.highlight + 1e-7);
        }
  EXPECT_GT(lit, 80);
}

TEST(LearnerShader, HasTheFresnelOfDielectricsButForSchlicksForm) {
  // What Schlick's form differs by from the exact curve at the F0 of skin, cloth and leather, whose S lies
  // between 0.184 and 0.263: never more than 0.036 of the light, and nothing at normal incidence.
  for (const double f0 : {0.028, 0.041, 0.056})
    for (int degrees = 0; degrees <= 80; degrees += 5) {
      const double c = std::cos(degrees * M_PI / 180);
      const double schlick = f0 + (1 - f0) * learner::shading::power5(1 - c);
      const double exact =
          renderer::fresnel_dielectric(static_cast<float>(c), renderer::eta_of_f0(static_cast<float>(f0)));
      EXPECT_NEAR(schlick, exact, degrees == 0 ? 1e-5 : 0.036) << f0 << " at " << degrees;
    }
}

}  // namespace
}  // namespace ohb
