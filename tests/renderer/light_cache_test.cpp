// What the cache of visibility knows is true, and what it does not know is left to rays.
#include "renderer/light_cache.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <limits>

#include "dataset/model/sampling.h"
#include "renderer/paired_pilots.h"
#include "renderer/quality.h"
#include "tests/support/test_models.h"

namespace ohb {
using namespace renderer;
using namespace surface;
namespace {

TEST(DirectionCells, DirectionsLieInTheirCells) {
  for (int cell = 0; cell < DirectionCells::kCount; ++cell)
    for (const float u : {0.01f, 0.3f, 0.99f})
      for (const float v : {0.01f, 0.7f, 0.99f})
        ASSERT_EQ(DirectionCells::of(DirectionCells::direction(cell, u, v)), cell) << u << " " << v;
  for (const Vec3f axis : {Vec3f{0, -1, 0}, Vec3f{1, 0, 0}, Vec3f{0, 0, -1}, Vec3f{-0.0f, -1, -0.0f}}) {
    EXPECT_GE(DirectionCells::of(axis), 0);
    EXPECT_LT(DirectionCells::of(axis), DirectionCells::kCount);
  }
}

TEST(DirectionCells, SolidAnglesAreWhatRandomDirectionsSay) {
  // Uniform directions by another way (height and angle); a chi-squared test of 255 degrees of freedom.
  constexpr int kDirections = 1000000;
  std::vector<double> counts(DirectionCells::kCount, 0);
  Random random(1, 2, 3);
  for (int i = 0; i < kDirections; ++i) {
    const double y = 2.0 * random.next() - 1, phi = 2 * M_PI * random.next(), r = std::sqrt(1 - y * y);
    ++counts[DirectionCells::of({static_cast<float>(r * std::cos(phi)), static_cast<float>(y),
                                 static_cast<float>(r * std::sin(phi))})];
  }
  double sum = 0, chi2 = 0;
  for (int cell = 0; cell < DirectionCells::kCount; ++cell) {
    sum += DirectionCells::solid_angle(cell);
    const double expected = kDirections * DirectionCells::solid_angle(cell) / (4 * M_PI);
    chi2 += std::pow(counts[cell] - expected, 2) / expected;
  }
  EXPECT_NEAR(sum, 4 * M_PI, 1e-2);
  EXPECT_LT(chi2, 330) << "1 in 1000 is above";
}

TEST(VisibilityCache, ABallSeesAllThatIsAboveItAndNothingBelow) {
  // The corners of a coarse ball stand out: without care they would shade what is just above a triangle.
  const auto scene = build_scene(sphere_model(20, 24, constant_set({})));
  const VisibilityCache cache(*scene);
  int above = 0, below = 0, wrong_above = 0, wrong_below = 0;
  for (uint32_t t = 0; t < scene->indices.size() / 3; ++t) {
    const uint32_t* corners = &scene->indices[3 * size_t{t}];
    const Vec3f p0 = scene->positions[corners[0]];
    const Vec3f cross_product = cross(scene->positions[corners[1]] - p0, scene->positions[corners[2]] - p0);
    if (length(cross_product) < 1e-3f) continue;
    const Vec3f ng = cross_product / length(cross_product);
    for (int cell = 0; cell < DirectionCells::kCount; ++cell) {
      const auto all = [&](auto test) {  // directions of the cell
        for (const float u : {0.0f, 0.5f, 1.0f})
          for (const float v : {0.0f, 0.5f, 1.0f})
            if (!test(dot(ng, DirectionCells::direction(cell, u, v)))) return false;
        return true;
      };
      const bool is_above = all([](float cosine) { return cosine > 0; });
      const bool is_below = all([](float cosine) { return cosine < -0.5f; });
      for (int c = 0; c < 3; ++c) {
        wrong_above += is_above && !cache.free[corners[c]][cell];
        wrong_below += is_below && cache.free[corners[c]][cell];
        above += is_above, below += is_below;
      }
    }
  }
  EXPECT_GT(above, 10000);
  EXPECT_GT(below, 10000);
  EXPECT_LT(wrong_above, above / 500) << "grazing rays may hit what they start from";
  EXPECT_EQ(wrong_below, 0);
}

Environment sky(Vec3f radiance, float sun = 0) {
  Environment environment;
  environment.name = "sky";
  environment.radiance = constant_radiance(radiance, 32);
  if (sun > 0)
    for (int c = 0; c < 3; ++c) environment.radiance.pixel(45, 8)[c] = sun;
  return environment;
}

/// A bowl that shades and lights itself, fine against its shadows.
Model bowl(const TestMaterial& material, int columns = 48, float depth_cm = 60) {
  return grid_model(
      columns, columns,
      [=](float u, float v) {
        const float x = 2 * u - 1, y = 2 * v - 1;
        return Vec3f{40 * x, 40 * v, 0.5f * depth_cm * (x * x + y * y)};
      },
      constant_set(material));
}

struct Pictures {
  std::vector<std::vector<std::vector<float>>> rays, cache;  // image, light
};

Pictures render_both(const Model& model, const std::vector<Environment>& environments,
                     const std::vector<PointLight>& points, RenderSettings settings, int images = 16) {
  const auto scene = build_scene(model);
  const auto lights = prepare_lights(environments, points);
  const auto visibility = std::make_shared<const VisibilityCache>(*scene);
  Pictures pictures;
  for (uint64_t k = 0; k < static_cast<uint64_t>(images); ++k)
    for (auto* stack : {&pictures.rays, &pictures.cache}) {
      settings.seed = 10 + 2 * k + (stack == &pictures.cache);
      settings.visibility = stack == &pictures.cache ? visibility : nullptr;
      stack->emplace_back();
      for (const SampleLight& light :
           render_lights({*scene, *lights, fit_camera(model.positions_cm), 0.3}, settings))
        stack->back().push_back(light.radiance.values);
    }
  return pictures;
}

RenderSettings small_settings() {
  RenderSettings settings;
  settings.size_px = 40;
  settings.spp = 64;
  return settings;
}

TEST(LightCache, PicturesEqualThoseByRays) {
  // Truth: the path tracer with shadow rays and 32 bounces. Rough and shiny; a sky, a low sun, a near point
  // light. A shallow bowl as clothes are, and a deep one of which most is lit by itself. Measured, the larger
  // of both roughnesses, and the upper end of its 99.8 % interval: 0.012 (0.015), 0.018 (0.024), 0.018
  // (0.019); deep: 0.039 (0.048), 0.047 (0.054), 0.036 (0.068). The seeds are fixed: only other random
  // numbers can raise a false alarm, those of the sun in one of 70 at most.
  struct Bound {
    float depth_cm, sky, sun, lamp;
  };
  for (const Bound& bound : {Bound{16, 0.015f, 0.024f, 0.019f}, Bound{60, 0.04f, 0.054f, 0.045f}})
    for (const float roughness : {0.6f, 0.2f}) {
      const Pictures pictures = render_both(
          bowl({{0.8f, 0.5f, 0.3f}, roughness, 0.2f, 0}, 48, bound.depth_cm),
          {sky({0.5f, 0.7f, 1}), sky({0.1f, 0.1f, 0.1f}, 30)}, {{"lamp", {30, 60, 80}, 2}}, small_settings());
      const float bounds[] = {bound.sky, bound.sun, bound.lamp};
      for (size_t l = 0; l < 3; ++l) {
        const SquaredDifference d = squared_difference(pictures.rays, l, pictures.cache, l, 0.002);
        EXPECT_LT(std::sqrt(std::max(0.0, d.value)), bounds[l])
            << bound.depth_cm << " cm deep, roughness " << roughness << ", light " << l;
      }
    }
}

TEST(LightCache, NoBouncesWhereNoneAreAsked) {
  RenderSettings settings = small_settings();
  settings.max_bounces = 0;
  const Pictures pictures =
      render_both(bowl({{0.9f, 0.9f, 0.9f}, 0.6f, 0.2f, 0}), {sky({1, 1, 1})}, {}, settings);
  const SquaredDifference d = squared_difference(pictures.rays, 0, pictures.cache, 0, 0.002);
  EXPECT_LT(std::sqrt(std::max(0.0, d.value)), 0.01) << "bounces bring a third of this bowl's light";
}

TEST(LightCache, WhatHighlightsShowHasOneBounceLess) {
  // A flat mirror and a flat white wall, one against the other. With one bounce the mirror shows the wall in
  // the light of the sky alone, without what the mirror sends there. Rough, since the cache forgets that
  // smooth walls send less to the other side (Burley's diffuse light; 1.8 % of this picture at roughness
  // 0.2).
  constexpr int kSize_px = 64;
  Model model = grid_model(
      48, 24,
      [](float u, float v) {
        return Vec3f{40 * (2 * u - 1), 40 * v, 40 * std::fabs(2 * u - 1)};
      },
      constant_set({{0.9f, 0.9f, 0.9f}, 1.0f, 0, 0}, kSize_px));
  for (int y = 0; y < kSize_px; ++y)
    for (int x = 0; x < kSize_px / 2; ++x) {
      for (int c = 0; c < 3; ++c) model.sets[0].albedo.pixel(x, y)[c] = 0;
      *model.sets[0].roughness.pixel(x, y) = 0.2f, *model.sets[0].specular.pixel(x, y) = 1;
    }
  RenderSettings settings = small_settings();
  settings.max_bounces = 1;
  const Pictures pictures = render_both(model, {sky({1, 1, 1})}, {}, settings);
  const auto sum = [](const std::vector<std::vector<std::vector<float>>>& images) {
    double total = 0;
    for (const auto& image : images)
      for (const float value : image[0]) total += value;
    return total;
  };
  EXPECT_NEAR(sum(pictures.cache) / sum(pictures.rays), 1, 0.01);
}

TEST(LightCache, GivesNoMoreLightThanTheFurnaceHas) {
  // White (of a roughness at which Burley's diffuse keeps energy), under a sky of 1: no surface is lit by
  // more than 1 x pi, and bounces make up for most of the shade.
  const auto scene = build_scene(bowl({{1, 1, 1}, 0.5f, 0, 0}));
  const auto lights = prepare_lights({sky({1, 1, 1})}, {});
  const VisibilityCache visibility(*scene);
  const LightCache cache(visibility, *scene, *lights, 0, 32);
  double shaded = 0, filled = 0;
  for (uint32_t t = 0; t < scene->indices.size() / 3; ++t) {
    const uint32_t* corners = &scene->indices[3 * size_t{t}];
    const float even[3] = {1.0f / 3, 1.0f / 3, 1.0f / 3};
    const LightCache::Known known = cache.known(corners);
    float sees = 0;
    for (int cell = 0; cell < DirectionCells::kCount; ++cell) {
      const float cosine = dot(visibility.normal[corners[0]], DirectionCells::direction(cell, 0.5f, 0.5f));
      const float share =
          0.5f * (static_cast<float>(known.free[cell]) + static_cast<float>(known.maybe[cell]));
      sees += share * std::max(0.0f, cosine) * DirectionCells::solid_angle(cell) * kInvPi;
    }
    const float from_surfaces = cache.from_surfaces(corners, even, false, 0).x;
    ASSERT_LT(sees + from_surfaces, 1.3f) << "a bit a cell: noise";
    shaded += 1 - sees, filled += from_surfaces;
  }
  EXPECT_GT(filled / shaded, 0.85) << "the bounces of a white bowl";
  EXPECT_LT(filled / shaded, 1.02);
}

TEST(LightCache, SameBitsForAnyThreadCount) {
  const Model model = bowl({{0.8f, 0.5f, 0.3f}, 0.4f, 0.2f, 0.3f}, 16);
  RenderSettings settings = small_settings();
  settings.adaptive = true;
  const Pictures all = render_both(model, {sky({1, 1, 1}, 100)}, {{"lamp", {30, 60, 80}, 2}}, settings, 1);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const Pictures alone = render_both(model, {sky({1, 1, 1}, 100)}, {{"lamp", {30, 60, 80}, 2}}, settings, 1);
  EXPECT_EQ(all.cache, alone.cache);
}

TEST(LightCache, BadTexelsAndTrianglesOfNoAreaDoNoHarm) {
  Model model = bowl({{0.8f, 0.5f, 0.3f}, 0.6f, 0.2f, 0}, 12);
  model.sets[0].albedo.values[0] = std::numeric_limits<float>::quiet_NaN();
  model.triangles.push_back(triangle_of(3, 3, 4));
  model.triangles.push_back(triangle_of(7, 7, 7));
  const Pictures pictures =
      render_both(model, {sky({1, 1, 1})}, {{"lamp", model.positions_cm[5], 2}}, small_settings(), 1);
  for (const auto& light : pictures.cache[0])
    for (const float value : light) ASSERT_TRUE(std::isfinite(value));
}

TEST(LightCache, AutoKeepsRaysWhereShadowsAreSmallerThanTriangles) {
  // A board of two triangles below a ball: no corner of the board is in the ball's shadow.
  Model model = sphere_model(5, 24, constant_set({{0.6f, 0.6f, 0.6f}, 0.6f, 0.2f, 0}));
  const auto base = static_cast<uint32_t>(model.positions_cm.size());
  for (const Vec3f p : {Vec3f{-30, -0.1f, -30}, {30, -0.1f, -30}, {30, -0.1f, 30}, {-30, -0.1f, 30}})
    model.positions_cm.push_back(p), model.uvs.push_back({0.5f, 0.5f});
  model.triangles.push_back(triangle_of(base, base + 3, base + 1));
  model.triangles.push_back(triangle_of(base + 1, base + 3, base + 2));
  RenderSettings settings = small_settings();
  settings.spp = 256;
  QualityView view{fit_camera(model.positions_cm), 0};
  const auto prepare = [&](const Model& m) {
    return prepare_scene(m, {sky({0.2f, 0.2f, 0.2f}, 300)}, {}, {view}, settings, {Quality::kAuto, 0.02, 60});
  };
  const PreparedScene coarse = prepare(model);
  EXPECT_TRUE(coarse.needs.shadow_rays);
  EXPECT_EQ(coarse.visibility, nullptr);
}

TEST(LightCache, AutoKeepsRaysWhereMirrorsShowMirrors) {
  // What a highlight shows has the light at its vertices, the same in all directions.
  RenderSettings settings = small_settings();
  settings.spp = 256;
  const auto keeps_rays = [&](const Model& model) {
    const QualityView view{fit_camera(model.positions_cm), 0};
    return prepare_scene(model, {sky({1, 1, 1})}, {}, {view}, settings, {Quality::kAuto, 0.04, 400})
        .needs.shadow_rays;
  };
  const TestMaterial polished{{0.5f, 0.5f, 0.5f}, 0.15f, 0.2f, 0};
  Model model = bowl(polished, 24, 40);
  EXPECT_FALSE(keeps_rays(model));
  constexpr int kSize_px = 64;
  model.sets[0] = constant_set(polished, kSize_px);
  for (int y = 0; y < kSize_px; ++y)
    for (int x = 0; x < kSize_px / 2; ++x) {
      for (int c = 0; c < 3; ++c) model.sets[0].albedo.pixel(x, y)[c] = 0;
      *model.sets[0].specular.pixel(x, y) = 1;
    }
  EXPECT_TRUE(keeps_rays(model)) << "half of it is a mirror";
}

}  // namespace
}  // namespace ohb
