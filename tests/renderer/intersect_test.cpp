// Rays that pass what they meet: the triangle that a walk enters by, and layers of cut-outs.
#include <gtest/gtest.h>
#include <immintrin.h>

#include "renderer/random_walk.h"
#include "renderer/render.h"
#include "tests/support/test_models.h"

namespace ohb {
using namespace renderer;
using namespace surface;
namespace {

constexpr int kRays = 300'000;

/// As in the threads that render: subnormal numbers count as 0.
class Intersect : public testing::Test {
 protected:
  void SetUp() override {
    mode_ = _mm_getcsr();
    _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
    _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
  }
  void TearDown() override { _mm_setcsr(mode_); }

  Vec3f random_direction() {
    const float z = 2 * random_.next() - 1, sine = std::sqrt(std::max(0.0f, 1 - z * z));
    const SineCosine phi = sine_cosine_of_turns(random_.next());
    return {sine * phi.cosine, sine * phi.sine, z};
  }

  Random random_{1, 2, 3};
  RayCounts counts_;

 private:
  unsigned int mode_ = 0;
};

// On AMD, Embree reports one triangle in a thousand again from just behind its own hit, from anywhere up to
// the next float or two: a ray that goes there and no farther never gets away.
TEST_F(Intersect, WalksLeaveTheTriangleTheyEnterBy) {
  const auto scene = build_scene(sphere_model(10, 24, constant_set({})));
  int lost = 0;
  for (int i = 0; i < kRays; ++i) {
    Hit entry{static_cast<uint32_t>(random_.next() * static_cast<float>(scene->attributes.size())),
              random_.next(), random_.next(), 0};
    if (entry.u + entry.v > 1) entry.u = 1 - entry.u, entry.v = 1 - entry.v;
    const Vec3f p = position_at(*scene, entry), d = random_direction();
    if (std::fabs(p.y - 10) > 9.6f) continue;  // at a pole triangles have no area
    const Ray ray{p, dot(d, geometric_normal(*scene, entry.triangle)) < 0 ? d : -d};
    // In a lane of its own, beside lanes that are not asked.
    const int lane = i % 8;
    int lanes[8] = {};
    SolidRay rays[8];
    lanes[lane] = -1;
    rays[lane] = {ray, 100, entry.triangle, false, {}};
    intersect_solids<false>(*scene, lanes, rays, counts_);
    EXPECT_TRUE(!rays[lane].is_hit || rays[lane].hit.triangle != entry.triangle);
    lost += !rays[lane].is_hit;
  }
  EXPECT_LT(lost, kRays / 1000);
}

// Two layers of a half transparent ball.
TEST_F(Intersect, EachLayerTakesItsShareOnce) {
  TextureSet set = constant_set({});
  set.alpha = set.roughness;
  for (float& v : set.alpha.values) v = 0.5f;
  const auto scene = build_scene(sphere_model(10, 24, set));
  int other = 0;
  for (int i = 0; i < kRays; ++i) {
    const Vec3f towards = random_direction();
    const WaitingLight light{
        {Vec3f{0, 10, 0} - 30 * towards, towards}, std::numeric_limits<float>::infinity(), {1, 1, 1}, 0};
    float share = 0;
    transmittances<true>(*scene, &light, 1, counts_, &share);
    other += share != 0.25f;
  }
  EXPECT_LT(other, kRays / 10000);
}

// Strands are drawn on layers that may lie in one place; each counts for the lights, as in Cycles.
TEST_F(Intersect, LayersInOnePlaceTakeTheirSharesEach) {
  TextureSet set = constant_set({});
  set.alpha = set.roughness;
  for (float& v : set.alpha.values) v = 0.5f;
  Model model = sphere_model(10, 24, set);
  const std::vector<ModelTriangle> once = model.triangles;
  for (int copies = 0; copies < 2; ++copies)
    model.triangles.insert(model.triangles.end(), once.begin(), once.end());
  const auto scene = build_scene(model);
  int other = 0;
  for (int i = 0; i < kRays / 8; ++i) {
    // Eight at once, of which some end inside, before the far side.
    WaitingLight lights[8];
    float expected[8], shares[8];
    for (int k = 0; k < 8; ++k) {
      const Vec3f towards = random_direction();
      const bool ends_inside = random_.next() < 0.5f;
      lights[k] = {{Vec3f{0, 10, 0} - 30 * towards, towards},
                   ends_inside ? 30 : std::numeric_limits<float>::infinity(),
                   {1, 1, 1},
                   0};
      expected[k] = ends_inside ? 0.125f : 0.015625f;
    }
    transmittances<true>(*scene, lights, 8, counts_, shares);
    for (int k = 0; k < 8; ++k) other += shares[k] != expected[k];
  }
  EXPECT_LT(other, kRays / 10000);
}

}  // namespace
}  // namespace ohb
