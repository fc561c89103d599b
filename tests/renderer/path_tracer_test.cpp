// Whole images: analytic answers, linearity, and equality for any thread count.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

#include "dataset/model/sampling.h"
#include "renderer/render.h"
#include "tests/support/test_models.h"

namespace ohb {
using namespace renderer;
namespace {

Environment constant_environment(float value) {
  Environment environment;
  environment.name = "constant";
  environment.radiance = constant_radiance({value, value, value});
  return environment;
}

Environment sunny_environment(float sun) {
  Environment environment;
  environment.name = "sunny";
  environment.radiance = Image(64, 32, 3);
  Random random(2, 2, 2);
  for (float& v : environment.radiance.values) v = 0.5f * random.next();
  for (int c = 0; c < 3; ++c) environment.radiance.pixel(45, 9)[c] = sun;
  return environment;
}

double mean_of(const Image& image, int channel) {
  double sum = 0;
  for (size_t i = static_cast<size_t>(channel); i < image.values.size(); i += image.channels)
    sum += image.values[i];
  return sum / (static_cast<double>(image.values.size()) / image.channels);
}

// A camera so near a large plane that every pixel sees it head-on.
Camera narrow_camera(float center_y_cm) {
  Camera camera;
  camera.center_y_cm = center_y_cm;
  camera.distance_cm = 100;
  camera.half_width = 0.01f;
  return camera;
}

TEST(PathTracer, FurnaceOnAPlaneEqualsCycles) {
  // Golden value of Cycles 3.4.1: base .8, specular .5 (F0 .04), roughness .5, head-on: .8419; blue .0370.
  TestMaterial material;
  material.albedo = {0.8f, 0.4f, 0};
  material.specular = 0.2213f;  // sRGB_to_linear gives .0400
  const auto scene = build_scene(plane_model(1000, constant_set(material)));
  RenderSettings settings;
  settings.size_px = 64;
  settings.spp = 1024;
  const auto images = render_lights(
      {*scene, *prepare_lights({constant_environment(1)}, {}), narrow_camera(500), 0}, settings);
  EXPECT_NEAR(mean_of(images[0].radiance, 0), 0.8419, 5e-4);
  EXPECT_NEAR(mean_of(images[0].radiance, 2), 0.0370, 5e-4);
}

TEST(PathTracer, PointLightOnADiffusePlaneIsAnalytic) {
  TestMaterial material;
  material.albedo = {0.5f, 0.5f, 0.5f};
  material.specular = 0;
  material.roughness = 0;  // no retro-reflection: f = albedo / pi (1 - wv / 2)(1 - wl / 2)
  const auto scene = build_scene(plane_model(1000, constant_set(material)));
  RenderSettings settings;
  settings.size_px = 16;
  settings.spp = 4;
  const float height_cm = 200, intensity = 3;
  const auto images = render_lights(
      {*scene, *prepare_lights({}, {{"lamp", {0, 500, height_cm}, intensity}}), narrow_camera(500), 0},
      settings);
  EXPECT_EQ(images[0].name, "lamp");
  // 1 cm around the foot of a lamp at 2 m: the cosine and distance change by 1e-4 at most.
  EXPECT_NEAR(mean_of(images[0].radiance, 1), 0.5 / M_PI * intensity / 4, 2e-4);
}

TEST(PathTracer, ShadesByTheModelsOwnNormals) {
  TestMaterial material;
  material.specular = 0;
  material.roughness = 0;
  Model plane = plane_model(1000, constant_set(material));
  RenderSettings settings;
  settings.size_px = 16;
  settings.spp = 4;
  const auto lamp = prepare_lights({}, {{"lamp", {0, 500, 200}, 3}});
  const auto picture = [&] {
    return render_lights({*build_scene(plane), *lamp, narrow_camera(500), 0}, settings)[0].radiance;
  };
  const Image smooth = picture();
  plane.normals = smooth_normals(plane);
  EXPECT_EQ(picture().values, smooth.values);
  const float tilt = 0.5f;
  plane.normals.assign(plane.positions_cm.size(), {std::sin(tilt), 0, std::cos(tilt)});
  EXPECT_NEAR(render_maps(*build_scene(plane), narrow_camera(500), 0, settings).normal.pixel(8, 8)[0],
              std::sin(tilt), 1e-5);
  // f = albedo / pi (1 - wv / 2)(1 - wl / 2) with w = (1 - cos)^5 of both, times the cosine.
  const double weight = 1 - 0.5 * std::pow(1 - std::cos(tilt), 5);
  EXPECT_NEAR(mean_of(picture(), 0) / mean_of(smooth, 0), std::cos(tilt) * weight * weight, 2e-3);
  plane.normals.pop_back();
  EXPECT_THROW(build_scene(plane), std::logic_error);
}

TEST(PathTracer, EachLightOfOnePassEqualsThatLightAlone) {
  const auto scene = build_scene(sphere_model(50, 48, constant_set({})));
  const Camera camera = fit_camera(sphere_model(50, 48, constant_set({})).positions_cm);
  RenderSettings settings;
  settings.size_px = 24;
  settings.spp = 1500;
  const std::vector<Environment> environments = {constant_environment(0.7f), sunny_environment(800)};
  const std::vector<PointLight> points = {{"lamp", {100, 200, 150}, 2}};
  const auto together = render_lights({*scene, *prepare_lights(environments, points), camera, 0.3}, settings);
  settings.seed = 99;
  const auto alone0 = render_lights({*scene, *prepare_lights({environments[0]}, {}), camera, 0.3}, settings);
  const auto alone1 = render_lights({*scene, *prepare_lights({environments[1]}, {}), camera, 0.3}, settings);
  const auto alone2 = render_lights({*scene, *prepare_lights({}, points), camera, 0.3}, settings);
  ASSERT_EQ(together.size(), 3u);
  EXPECT_NEAR(mean_of(together[0].radiance, 1) / mean_of(alone0[0].radiance, 1), 1, 5e-3);
  EXPECT_NEAR(mean_of(together[1].radiance, 1) / mean_of(alone1[0].radiance, 1), 1, 1e-2);
  EXPECT_NEAR(mean_of(together[2].radiance, 1) / mean_of(alone2[0].radiance, 1), 1, 5e-3);
}

TEST(PathTracer, EndingAtRoughSurfacesIsUnbiased) {
  // Both rough and narrow highlights, and skin; each image's mean within five standard errors of their
  // difference over the seeds.
  for (const float roughness : {0.2f, 0.6f})
    for (const float sss : {0.0f, 0.5f}) {
      TestMaterial material;
      material.roughness = roughness;
      material.sss = sss;
      const Model ball = sphere_model(50, 64, constant_set(material));
      const auto scene = build_scene(ball);
      const auto lights = prepare_lights({sunny_environment(300)}, {});
      constexpr int kSeeds = 16;
      double sum = 0, squares = 0, mean = 0;
      for (uint64_t k = 0; k < kSeeds; ++k) {
        RenderSettings settings;
        settings.size_px = 16;
        settings.spp = 64;
        settings.max_bounces = 0;
        double means[2];
        for (const bool ends : {false, true}) {
          settings.seed = 1 + 2 * k + ends;
          settings.ends_at_rough_surfaces = ends;
          means[ends] = mean_of(
              render_lights({*scene, *lights, fit_camera(ball.positions_cm), 0}, settings)[0].radiance, 0);
        }
        const double difference = means[1] - means[0];
        sum += difference, squares += difference * difference, mean += means[0] / kSeeds;
      }
      const double error = std::sqrt((squares - sum * sum / kSeeds) / (kSeeds - 1) / kSeeds);
      EXPECT_LT(error, 0.01 * mean);
      EXPECT_NEAR(sum / kSeeds, 0, 5 * error) << roughness << " " << sss;
    }
}

TEST(PathTracer, TwiceTheLightIsTwiceTheImageBitForBit) {
  const auto scene = build_scene(sphere_model(50, 32, constant_set({})));
  const Camera camera = fit_camera(sphere_model(50, 32, constant_set({})).positions_cm);
  RenderSettings settings;
  settings.size_px = 16;
  settings.spp = 32;
  Environment once = sunny_environment(100), twice = once;
  for (float& v : twice.radiance.values) v *= 2;
  const auto a = render_lights({*scene, *prepare_lights({once}, {}), camera, 0}, settings);
  const auto b = render_lights({*scene, *prepare_lights({twice}, {}), camera, 0}, settings);
  for (size_t i = 0; i < a[0].radiance.values.size(); ++i)
    ASSERT_EQ(2 * a[0].radiance.values[i], b[0].radiance.values[i]);
}

TEST(PathTracer, TurningTheSubjectIsTurningTheLightBack) {
  // A sphere looks the same at every turn; only the environment may move. Turn by a quarter and shift the map
  // back.
  const auto scene = build_scene(sphere_model(50, 64, constant_set({})));
  const Camera camera = fit_camera(sphere_model(50, 64, constant_set({})).positions_cm);
  RenderSettings settings;
  settings.size_px = 16;
  settings.spp = 2000;
  const Environment environment = sunny_environment(300);
  const auto still = render_lights({*scene, *prepare_lights({environment}, {}), camera, 0}, settings);
  const auto turned = render_lights({*scene, *prepare_lights({environment}, {}), camera, M_PI / 2}, settings);
  EXPECT_NEAR(mean_of(still[0].radiance, 0) / mean_of(turned[0].radiance, 0), 1, 1e-2);
}

TEST(PathTracer, LightFromTheSideLightsThatSide) {
  // The brightest direction is +X (image centre): the subject's left, the picture's right.
  Environment environment;
  environment.name = "side";
  environment.radiance = Image(64, 32, 3);
  for (int c = 0; c < 3; ++c) environment.radiance.pixel(32, 16)[c] = 1000;
  EXPECT_GT(brightest_direction(environment).x, 0.99f);
  const auto scene = build_scene(sphere_model(50, 64, constant_set({})));
  const Camera camera = fit_camera(sphere_model(50, 64, constant_set({})).positions_cm);
  RenderSettings settings;
  settings.size_px = 32;
  settings.spp = 64;
  const auto images = render_lights({*scene, *prepare_lights({environment}, {}), camera, 0}, settings);
  double left = 0, right = 0;
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 32; ++x) (x < 16 ? left : right) += images[0].radiance.pixel(x, y)[1];
  EXPECT_GT(right, 10 * left);
}

void expect_same_bits_for_any_thread_count(const Model& model) {
  const Camera camera = fit_camera(model.positions_cm);
  RenderSettings settings;
  settings.size_px = 40;
  settings.spp = 16;
  settings.adaptive = true;
  const auto lights = prepare_lights({sunny_environment(500)}, {{"lamp", {50, 150, 100}, 1}});
  std::vector<std::vector<float>> results, maps;
  for (const size_t threads : {1, 2, 8, 8}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const auto scene = build_scene(model);
    const auto images = render_lights({*scene, *lights, camera, 0.7}, settings);
    results.push_back(images[0].radiance.values);
    results.back().insert(results.back().end(), images[1].radiance.values.begin(),
                          images[1].radiance.values.end());
    maps.push_back(render_maps(*scene, camera, 0.7, settings).normal.values);
  }
  for (size_t i = 1; i < results.size(); ++i) {
    EXPECT_EQ(results[0], results[i]);
    EXPECT_EQ(maps[0], maps[i]);
  }
}

TEST(PathTracer, BitIdenticalForAnyThreadCount) {
  // Opaque, and layers of a cut-out, some of them in one place; budgets follow the work that rays were.
  TextureSet strands = constant_set({});
  strands.alpha = strands.roughness;
  for (float& v : strands.alpha.values) v = 0.3f;
  Model layered = sphere_model(50, 32, strands);
  const std::vector<ModelTriangle> once = layered.triangles;
  for (int copies = 0; copies < 3; ++copies)
    layered.triangles.insert(layered.triangles.end(), once.begin(), once.end());
  for (const Model& model : {sphere_model(50, 32, constant_set({})), layered})
    expect_same_bits_for_any_thread_count(model);
}

TEST(PathTracer, ExactCopiesOfFacesThrowNoShadowOnEachOther) {
  const Model once = sphere_model(50, 32, constant_set({}));
  Model twice = once;
  twice.triangles.insert(twice.triangles.end(), once.triangles.begin(), once.triangles.end());
  twice.normals = smooth_normals(once);
  RenderSettings settings;
  settings.size_px = 40;
  settings.spp = 16;
  const auto lights = prepare_lights({sunny_environment(500)}, {{"lamp", {50, 150, 100}, 1}});
  const auto render = [&](const Model& model) {
    return render_lights({*build_scene(model), *lights, fit_camera(once.positions_cm), 0.7}, settings);
  };
  const auto of_once = render(once), of_twice = render(twice);
  for (size_t l = 0; l < of_once.size(); ++l)
    EXPECT_NEAR(mean_of(of_twice[l].radiance, 0) / mean_of(of_once[l].radiance, 0), 1, 1e-5) << l;
}

TEST(PathTracer, HalfTransparentSheetHalvesTheLight) {
  // A black sheet with opacity .25 in front of the lamp leaves 3/4 of the light on the plane behind.
  TestMaterial material;
  material.albedo = {0.5f, 0.5f, 0.5f};
  material.specular = 0;
  Model model = plane_model(1000, constant_set(material));
  TextureSet sheet = constant_set({{0, 0, 0}, 1, 0, 0});
  sheet.alpha = sheet.roughness;
  for (float& v : sheet.alpha.values) v = 0.25f;
  model.sets.push_back(sheet);
  const uint32_t first = static_cast<uint32_t>(model.positions_cm.size());
  for (uint32_t i = 0; i < first; ++i) {
    model.positions_cm.push_back(model.positions_cm[i] + Vec3f{0, 0, 150});
    model.uvs.push_back(model.uvs[i]);
  }
  model.triangles.push_back(triangle_of(first, first + 1, first + 3, 1));
  model.triangles.push_back(triangle_of(first, first + 3, first + 2, 1));
  RenderSettings settings;
  settings.size_px = 16;
  settings.spp = 64;
  const auto lights = prepare_lights({}, {{"lamp", {0, 500, 200}, 3}});
  const auto open = render_lights(
      {*build_scene(plane_model(1000, constant_set(material))), *lights, narrow_camera(500), 0}, settings);
  const auto covered = render_lights({*build_scene(model), *lights, narrow_camera(500), 0}, settings);
  EXPECT_NEAR(mean_of(covered[0].radiance, 0) / mean_of(open[0].radiance, 0), 0.75, 1e-3);
  // The camera (at 1 m) stands between; put it behind the sheet: what it sees is 3/4 of that again.
  Camera behind = narrow_camera(500);
  behind.distance_cm = 400;
  behind.half_width = 0.0025f;
  settings.spp = 4000;
  const auto seen = render_lights({*build_scene(model), *lights, behind, 0}, settings);
  EXPECT_NEAR(mean_of(seen[0].radiance, 0) / mean_of(open[0].radiance, 0), 0.75 * 0.75, 5e-3);
}

TEST(PathTracer, ExtremeSunLeavesNoNan) {
  for (const float sun : {1e5f, 1e8f, 1e30f}) {
    const auto scene = build_scene(sphere_model(50, 32, constant_set({{1, 1, 1}, 0, 1, 0})));
    const Camera camera = fit_camera(sphere_model(50, 32, constant_set({})).positions_cm);
    RenderSettings settings;
    settings.size_px = 16;
    settings.spp = 16;
    RenderStatistics statistics;
    const auto images = render_lights({*scene, *prepare_lights({sunny_environment(sun)}, {}), camera, 0},
                                      settings, &statistics);
    for (const float v : images[0].radiance.values) ASSERT_TRUE(std::isfinite(v)) << sun;
    EXPECT_EQ(statistics.nonfinite, 0u) << sun;
  }
}

}  // namespace
}  // namespace ohb
