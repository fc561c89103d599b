// What auto leaves out: nothing that is seen, and what is not needed.
#include "renderer/quality.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

#include "dataset/model/sampling.h"
#include "renderer/coarser.h"
#include "renderer/paired_pilots.h"
#include "tests/support/test_models.h"

namespace ohb {
using namespace renderer;
using namespace surface;
namespace {

TEST(PairedPilots, IntervalHoldsTheTruthAndNoiseDoesNotCount) {
  // b - a = 0.1 x noise-free gradient + noise shared in part; a = 1 + noise.
  constexpr size_t kValues = 3 * 320;
  constexpr int kTrials = 300, kImages = 16;
  Random random(4, 5, 6);
  const auto noise = [&] { return 3.4641f * (random.next() - 0.5f); };
  for (const float step : {0.0f, 0.1f}) {
    double square = 0, truth = 0, mean = 0;
    for (size_t i = 0; i < kValues; ++i)
      truth += std::pow(step * static_cast<float>(i) / kValues, 2) / kValues;
    int inside = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
      PilotStack a, b;
      for (int k = 0; k < kImages; ++k) {
        a.push_back({std::vector<float>(kValues)});
        b.push_back({std::vector<float>(kValues)});
        for (size_t i = 0; i < kValues; ++i) {
          a.back()[0][i] = 1 + noise();
          b.back()[0][i] = a.back()[0][i] + step * static_cast<float>(i) / kValues + 0.5f * noise();
        }
      }
      const SquaredDifference d = squared_difference(a, 0, b, 0, 0.02);
      inside += d.low <= truth && truth <= d.high;
      mean += d.value / kTrials, square += d.value * d.value / kTrials;
    }
    EXPECT_GE(inside, kTrials * 96 / 100) << "98 % intervals: 99.9 % of the test's runs have more";
    const double error = std::sqrt((square - mean * mean) / kTrials);
    EXPECT_NEAR(mean, truth, 4 * error + 0.01 * truth);  // a ratio of estimates: its bias is of second order
    EXPECT_LT(error, 1e-4) << "half a unit of noise is 250 times this";
  }
}

TEST(PairedPilots, DarknessIsNotAgreement) {
  // Differences, but no light above the noise: anything may be.
  PilotStack a, b;
  for (int k = 0; k < 16; ++k) {
    a.push_back({{k % 2 ? 1.0f : -1.0f, 0, 0}});
    b.push_back({{0, 0, 0}});
  }
  EXPECT_TRUE(std::isinf(squared_difference(a, 0, b, 0, 0.02).high));
  EXPECT_EQ(squared_difference(b, 0, b, 0, 0.02).high, 0);
}

TEST(Coarser, EnvironmentsKeepTheirPower) {
  Environment environment;
  environment.radiance = Image(256, 128, 3);
  environment.radiance.pixel(40, 3)[0] = 1000;
  environment.radiance.pixel(200, 90)[1] = 7;
  const auto power = [](const Image& image, int channel) {
    double sum = 0;
    for (int y = 0; y < image.height_px; ++y)
      for (int x = 0; x < image.width_px; ++x)
        sum += image.pixel(x, y)[channel] *
               (std::cos(M_PI * y / image.height_px) - std::cos(M_PI * (y + 1) / image.height_px)) /
               image.width_px;
    return sum;
  };
  const Image coarse = coarser_environment(environment, 2).radiance;
  EXPECT_EQ(coarse.width_px, 64);
  for (int c = 0; c < 2; ++c) EXPECT_NEAR(power(coarse, c) / power(environment.radiance, c), 1, 2e-3);
  EXPECT_EQ(coarser_environment(environment, 9).radiance.width_px, 64) << "no coarser";
}

TEST(Coarser, MapsAreMeansAndOddOnesStay) {
  Model model = plane_model(10, constant_set({}, 128));
  for (size_t i = 0; i < model.sets[0].roughness.values.size(); ++i)
    model.sets[0].roughness.values[i] = static_cast<float>(i % 2);
  model.sets.push_back(constant_set({}, 75));
  EXPECT_EQ(largest_map_px(model), 128);
  const Model coarse = with_coarser_maps(model, 32);
  EXPECT_EQ(coarse.sets[0].albedo.width_px, 32);
  EXPECT_EQ(coarse.sets[1].albedo.width_px, 75);
  for (const float v : coarse.sets[0].roughness.values) ASSERT_EQ(v, 0.5f);
  EXPECT_EQ(build_scene(coarse) == nullptr, false);
}

Environment environment_of(float sun, int width_px) {
  Environment environment;
  environment.name = "sky";
  environment.radiance = constant_radiance({0.5f, 0.5f, 0.5f}, width_px / 2);
  if (sun > 0)
    for (int c = 0; c < 3; ++c) environment.radiance.pixel(width_px * 3 / 4 + 3, width_px / 8)[c] = sun;
  return environment;
}

struct Case {
  Model model;
  std::vector<Environment> environments;
  RenderSettings settings;
  Case(Model m, Environment environment) : model(std::move(m)), environments{std::move(environment)} {
    settings.size_px = 40;
    settings.spp = 256;
  }
  std::vector<QualityView> views() const { return {{fit_camera(model.positions_cm), 0}}; }
  PreparedScene prepare(double tolerance) const {
    return prepare_scene(model, environments, {}, views(), settings, {Quality::kAuto, tolerance, 50});
  }
  /// What the relative change of the image is at least, from other images than the choice was made by (98 %).
  double real_change_at_least(const PreparedScene& prepared) const {
    const PreparedScene all = prepare_scene(model, environments, {}, views(), settings, {});
    RenderSettings s = settings;
    s.spp = 48;
    PilotStack stacks[2];
    for (uint64_t k = 0; k < 16; ++k)
      for (const PreparedScene* p : {&all, &prepared}) {
        s.seed = 1000 + 2 * k + (p == &all ? 0 : 1);
        stacks[p == &all ? 0 : 1].push_back(
            {render_lights({*p->lit, *p->lights, views()[0].camera, 0}, p->settings_for(s))[0]
                 .radiance.values});
      }
    return std::sqrt(std::max(0.0, squared_difference(stacks[0], 0, stacks[1], 0, 0.02).low));
  }
};

Model bowl(const TextureSet& set, float steepness_cm = 40) {
  return grid_model(
      24, 24,
      [=](float u, float v) {
        const float x = 2 * u - 1, y = 2 * v - 1;
        return Vec3f{40 * x, 40 * v, steepness_cm * (x * x + y * y)};
      },
      set);
}

TEST(Quality, LeavesOutWhatABallInTheSkyDoesNotNeed) {
  // A convex ball: no light comes from itself. An even sky: any resolution will do. Constant maps: likewise.
  const Case ball(sphere_model(20, 48, constant_set({}, 256)), environment_of(0, 256));
  const PreparedScene prepared = ball.prepare(0.02);
  EXPECT_EQ(prepared.needs.max_bounces, 0);
  EXPECT_EQ(prepared.needs.environment_px, 64);
  EXPECT_EQ(prepared.needs.map_px, 64);
  EXPECT_LE(prepared.error_high, 0.02);
  EXPECT_LT(ball.real_change_at_least(prepared), 0.02);
  EXPECT_NE(prepared.scene, prepared.lit) << "maps of a sample are from the full ones";
}

TEST(Quality, KeepsWhatIsSeen) {
  // A white bowl lives on its own light; a polished one under a small sun on the sky's detail.
  TestMaterial white{{0.9f, 0.9f, 0.9f}, 0.08f, 0.8f, 0};
  const Case deep(bowl(constant_set(white)), environment_of(3000, 512));
  const PreparedScene prepared = deep.prepare(0.02);
  EXPECT_GT(prepared.needs.max_bounces, 0);
  EXPECT_GT(prepared.needs.environment_px, 64);
  EXPECT_LT(deep.real_change_at_least(prepared), 0.02);
}

TEST(Quality, SubsurfaceByWhatItShows) {
  TestMaterial skin{{0.7f, 0.4f, 0.3f}, 0.4f, 0.18f, 0.5f};
  const Case wax(sphere_model(2, 32, constant_set(skin)), environment_of(0, 64));
  EXPECT_TRUE(wax.prepare(0.02).needs.subsurface) << "a radius of half a centimetre in a ball of two";
  const PreparedScene rough = wax.prepare(0.5);
  EXPECT_FALSE(rough.needs.subsurface);
  EXPECT_LT(wax.real_change_at_least(rough), 0.5);
}

TEST(Quality, SmallJobsAreRenderedAsTheyAre) {
  const Case ball(sphere_model(20, 32, constant_set({}, 256)), environment_of(0, 256));
  const PreparedScene prepared = prepare_scene(ball.model, ball.environments, {}, ball.views(), ball.settings,
                                               {Quality::kAuto, 0.02, 1});
  EXPECT_TRUE(prepared.tried.empty()) << "pilots would cost more than they save";
  EXPECT_EQ(prepared.scene, prepared.lit);
}

TEST(Quality, SameChoiceForAnyThreadCount) {
  const Case deep(bowl(constant_set({})), environment_of(100, 128));
  const PreparedScene all = deep.prepare(0.05);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const PreparedScene alone = deep.prepare(0.05);
  ASSERT_EQ(alone.tried.size(), all.tried.size());
  for (size_t i = 0; i < all.tried.size(); ++i) {
    EXPECT_EQ(alone.tried[i].high, all.tried[i].high);
    EXPECT_EQ(alone.tried[i].is_left_out, all.tried[i].is_left_out);
  }
}

}  // namespace
}  // namespace ohb
