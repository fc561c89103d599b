// Walks under the surface against the numbers of Cycles 3.4.1, a one-dimensional model and invariants.
#include "renderer/subsurface.h"

#include <gtest/gtest.h>

#include <cmath>

#include "renderer/random_walk.h"
#include "renderer/render.h"
#include "tests/support/test_models.h"

namespace ohb {
using namespace renderer;
using namespace surface;
namespace {

Environment white_environment() {
  Environment environment;
  environment.name = "white";
  environment.radiance = constant_radiance({1, 1, 1});
  return environment;
}

double mean_of(const Image& image, int channel) {
  double sum = 0;
  for (size_t i = static_cast<size_t>(channel); i < image.values.size(); i += image.channels)
    sum += image.values[i];
  return sum / (static_cast<double>(image.values.size()) / image.channels);
}

Camera narrow_camera(float center_y_cm) {
  Camera camera;
  camera.center_y_cm = center_y_cm;
  camera.distance_cm = 100;
  camera.half_width = 0.01f;
  return camera;
}

TestMaterial subsurface_material(Vec3f albedo) {
  TestMaterial material;
  material.albedo = albedo;
  material.specular = 0;
  material.roughness = 0;
  material.sss = 1;
  return material;
}

// Mean free path by radius, renderer reference table of Cycles 3.4.1 (measured): the staircase, not the root.
TEST(Subsurface, MeanFreePathIsCyclesStaircase) {
  EXPECT_NEAR(mean_free_path_a_radius(0.2f), 0.7485, 5e-5);
  EXPECT_NEAR(mean_free_path_a_radius(0.5f), 0.2582, 5e-5);
  EXPECT_NEAR(mean_free_path_a_radius(0.8f), 0.0716, 5e-5);
  EXPECT_NEAR(mean_free_path_a_radius(0.9f), 0.0271, 5e-5);
  EXPECT_EQ(mean_free_path_a_radius(0.9f), mean_free_path_a_radius(0.95f));
  EXPECT_NEAR(mean_free_path_a_radius(1.0f), 0.00174, 5e-6);
  EXPECT_NEAR(mean_free_path_a_radius(0.0f), std::sqrt(3.0), 1e-6);
}

// The same twelve steps, with their exponentials.
TEST(Subsurface, TreeEqualsTheBisectionThatItStandsFor) {
  const float fdr = -1.440f / (1.4f * 1.4f) + 0.710f / 1.4f + 0.668f + 0.0636f * 1.4f;
  const float a = 4.0f / 3.0f * (1 + fdr) / (1 - fdr);
  for (int i = 1; i < 2000; ++i) {
    const float colour = static_cast<float>(i) / 2011.0f;
    float low = 0, high = 1, middle = 0;
    for (int step = 0; step < 12; ++step) {
      middle = 0.5f * (low + high);
      const float s = std::sqrt(3 * (1 - middle));
      (0.5f * middle * (1 + std::exp(-a * s)) * std::exp(-s) < colour ? low : high) = middle;
    }
    ASSERT_EQ(mean_free_path_a_radius(colour), std::sqrt(3 * (1 - middle))) << colour;
  }
}

TEST(Subsurface, SingleScatteringAlbedo) {
  EXPECT_NEAR(single_scattering_albedo(0.2f), 0.6134, 1e-4);
  EXPECT_NEAR(single_scattering_albedo(0.5f), 0.9137, 1e-4);
  EXPECT_NEAR(single_scattering_albedo(0.8f), 0.9918, 1e-4);
  EXPECT_EQ(single_scattering_albedo(0.93f), 0.999999f);
  EXPECT_EQ(single_scattering_albedo(0), 0);
}

// Reflectance of a half-space in Cycles' model, times 41/42 of the exit lobe. From colour .92 on every medium
// has the same albedo and differs in nothing but scale: the cut at 256 segments is what keeps it from 1.
TEST(Subsurface, FurnaceOnAHalfSpace) {
  RenderSettings settings;
  settings.size_px = 64;
  settings.spp = 64;
  const auto furnace = [&](Vec3f albedo) {
    const auto scene = build_scene(plane_model(1000, constant_set(subsurface_material(albedo))));
    return render_lights({*scene, *prepare_lights({white_environment()}, {}), narrow_camera(500), 0},
                         settings)[0]
        .radiance;
  };
  // Within four standard errors, which the independent pixels tell (false alarms: 1 in 4000 for all four),
  // and the rounding of the published value.
  const auto expect_reflectance = [](const Image& image, int channel, double reflectance) {
    constexpr double kExit = 41.0 / 42, kRounding = 1e-4;
    const double mean = mean_of(image, channel), n = static_cast<double>(image.values.size()) / 3;
    double squares = 0;
    for (size_t i = static_cast<size_t>(channel); i < image.values.size(); i += 3)
      squares += std::pow(image.values[i] - mean, 2);
    const double standard_error = std::sqrt(squares / n / (n - 1));
    EXPECT_LT(standard_error, 1.5e-3);
    EXPECT_NEAR(mean, reflectance * kExit, 4 * standard_error + kRounding)
        << channel << ", standard error " << standard_error;
  };
  const Image low = furnace({0.2f, 0.5f, 0.8f});
  expect_reflectance(low, 0, 0.2018);
  expect_reflectance(low, 1, 0.5046);
  expect_reflectance(low, 2, 0.810);
  expect_reflectance(furnace({1, 1, 1}), 0, 0.9185);
  EXPECT_EQ(mean_of(furnace({0.5f, 0.5f, 0}), 2), 0);
}

/// Mean and squared standard error.
struct Estimate {
  double sum = 0, squares = 0;
  int count = 0;
  void add(double value) { sum += value, squares += value * value, ++count; }
  double mean() const { return sum / count; }
  double variance() const { return (squares / count - mean() * mean()) / count; }
};

/// One walk of one channel, isotropic and unguided: its weight where it comes out (`hit`), 0 if it does not.
double analog_walk(const Scene& scene, const WalkMedium& medium, int channel, Ray ray, Random& random,
                   Hit& hit) {
  double weight = medium.medium.entry_weight[channel];
  for (int segment = 0; segment < cycles::kMaxWalkSegments && weight > 1e-9; ++segment) {
    const float t = -std::log(1 - random.next()) / medium.medium.sigma_t_per_cm[channel];
    if (intersect_bvh(scene.opaque, 0, ray, 0, t, hit)) return weight;
    weight *= medium.medium.albedo[channel];
    ray.origin += t * ray.direction;
    const float z = 2 * random.next() - 1, sine = std::sqrt(std::max(0.0f, 1 - z * z));
    const SineCosine phi = sine_cosine_of_turns(random.next());
    ray.direction = {sine * phi.cosine, sine * phi.sine, z};
  }
  return 0;
}

// The walks (eight at once, guided, channels and strategies mixed) against the plainest ones: one at a time,
// one channel at a time, isotropic, distances by the standard library's logarithm. In a ball of five mean
// free paths of red, where guiding, the far side and the sheet's search all matter.
TEST(Subsurface, WalksEqualAnalogOnes) {
  const auto scene = build_scene(sphere_model(2, 48, constant_set(subsurface_material({0.9f, 0.6f, 0.3f}))));
  SurfaceTexel texel;
  texel.albedo = {0.9f, 0.6f, 0.3f};
  texel.sss = 0.5f;
  const WalkMedium medium(texel);
  const Hit entry{scene->opaque_count / 3, 0.3f, 0.3f, 0};
  const SurfacePoint point = surface_at(*scene, entry, geometric_normal(*scene, entry.triangle));
  const Frame frame(point.ng);
  Random random(7, 0, 0);
  // By channel: what comes out, and where (height along the entry's normal).
  Estimate guided[3], guided_height[3], analog[3], analog_height[3];
  RayCounts counts;
  for (int round = 0; round < 400; ++round) {
    std::vector<Walk> walks;
    for (int k = 0; k < 100; ++k) {
      const float u = random.next();
      const Vec3f inwards = -frame.to_world(sample_cosine_hemisphere(u, random.next()));
      walks.push_back({point.position, point.ng, point.ng, inwards, entry.triangle, &medium,
                       Random(9, static_cast<uint64_t>(round), static_cast<uint64_t>(k))});
    }
    walk_under_surface<false>(*scene, walks, counts);
    for (const Walk& walk : walks)
      for (int c = 0; c < 3; ++c) {
        const double weight = walk.is_out ? walk.exit.weight[c] : 0.0;
        guided[c].add(weight);
        guided_height[c].add(walk.is_out ? weight * dot(position_at(*scene, walk.exit.hit), point.ng) : 0);
      }
  }
  for (int c = 0; c < 3; ++c)
    for (int i = 0; i < 40000; ++i) {
      const float u = random.next();
      const Ray ray{point.position - 1e-5f * point.ng,
                    -frame.to_world(sample_cosine_hemisphere(u, random.next()))};
      Hit hit;
      const double weight = analog_walk(*scene, medium, c, ray, random, hit);
      analog[c].add(weight);
      analog_height[c].add(weight > 0 ? weight * dot(position_at(*scene, hit), point.ng) : 0);
    }
  // Six comparisons at four standard errors: one false alarm in 2600 seeds.
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(guided[c].mean(), analog[c].mean(),
                4 * std::sqrt(guided[c].variance() + analog[c].variance()))
        << c;
    EXPECT_NEAR(guided_height[c].mean(), analog_height[c].mean(),
                4 * std::sqrt(guided_height[c].variance() + analog_height[c].variance()))
        << c;
    EXPECT_LT(std::sqrt(guided[c].variance()), 0.01 * guided[c].mean());
  }
  EXPECT_EQ(counts.walks, 40000u);
}

// A sheet whose far side matters to red and hardly to blue: each channel guides backwards with a chance of
// its own, and the weight must know all three. Against plain walks along the depth alone.
TEST(Subsurface, WalksThroughASheetEqualAnalogOnes) {
  constexpr float kThickness_cm = 0.3f;
  constexpr int kWalks = 600000;
  SurfaceTexel texel;
  texel.albedo = {0.6f, 0.4f, 0.3f};
  texel.sss = 1;
  Model model = plane_model(1000, constant_set(subsurface_material(texel.albedo)));
  constexpr uint32_t kFront = 4;
  for (uint32_t i = 0; i < kFront; ++i)
    model.positions_cm.push_back(model.positions_cm[i] - Vec3f{0, 0, kThickness_cm});
  for (uint32_t i = 0; i < 2; ++i) {
    ModelTriangle back = model.triangles[i];
    std::swap(back.position[1], back.position[2]), std::swap(back.uv[1], back.uv[2]);
    for (uint32_t& p : back.position) p += kFront;
    model.triangles.push_back(back);
  }
  const auto scene = build_scene(model);
  const WalkMedium medium(texel);
  constexpr uint32_t kEntry = 0;  // the triangle that `start` lies in
  const Vec3f start{100, 300, 0}, ng{0, 0, 1};
  Random random(11, 0, 0);
  Estimate guided[2][3], analog[2][3];  // front, back
  RayCounts counts;
  for (int round = 0; round < kWalks / 100; ++round) {
    std::vector<Walk> walks;
    for (int k = 0; k < 100; ++k) {
      const float u = random.next();
      const Vec3f inwards = -sample_cosine_hemisphere(u, random.next());
      walks.push_back({start, ng, ng, inwards, kEntry, &medium,
                       Random(13, static_cast<uint64_t>(round), static_cast<uint64_t>(k))});
    }
    walk_under_surface<false>(*scene, walks, counts);
    for (const Walk& walk : walks)
      for (int side = 0; side < 2; ++side)
        for (int c = 0; c < 3; ++c)
          guided[side][c].add(
              walk.is_out && (walk.exit.hit.triangle >= 2) == (side == 1) ? walk.exit.weight[c] : 0.0);
  }
  for (int c = 0; c < 3; ++c)
    for (int i = 0; i < kWalks; ++i) {
      double depth = 0, weight = medium.medium.entry_weight[c];
      double down = std::sqrt(1 - double{random.next()});  // cosine of the direction
      for (int segment = 0; segment < cycles::kMaxWalkSegments; ++segment) {
        depth += down * -std::log(1 - random.next()) / medium.medium.sigma_t_per_cm[c];
        if (depth < 0 || depth > kThickness_cm) break;
        weight *= medium.medium.albedo[c];
        down = 2 * double{random.next()} - 1;
      }
      analog[0][c].add(depth < 0 ? weight : 0);
      analog[1][c].add(depth > kThickness_cm ? weight : 0);
    }
  // Six comparisons at four standard errors: one false alarm in 2600 seeds.
  for (int side = 0; side < 2; ++side)
    for (int c = 0; c < 3; ++c) {
      const double error = std::sqrt(guided[side][c].variance() + analog[side][c].variance());
      EXPECT_NEAR(guided[side][c].mean(), analog[side][c].mean(), 4 * error) << side << c;
      EXPECT_LT(error, 0.01 * analog[side][c].mean()) << side << c;
    }
}

TEST(Subsurface, LittleOfItIsNone) {
  RenderSettings settings;
  settings.size_px = 16;
  settings.spp = 16;
  const auto lights = prepare_lights({white_environment()}, {});
  const auto radiance_at = [&](float sss) {
    TestMaterial material = subsurface_material({0.6f, 0.4f, 0.2f});
    material.sss = sss;
    return render_lights(
               {*build_scene(plane_model(1000, constant_set(material))), *lights, narrow_camera(500), 0},
               settings)[0]
        .radiance.values;
  };
  const auto none = radiance_at(0);
  EXPECT_EQ(radiance_at(0.002f), none);
  EXPECT_EQ(radiance_at(0.0099f), none);
  EXPECT_NE(radiance_at(0.0101f), none);
}

TEST(Subsurface, SwitchedOffItIsDiffuse) {
  TestMaterial with = subsurface_material({0.6f, 0.4f, 0.2f}), without = with;
  without.sss = 0;
  RenderSettings settings;
  settings.size_px = 16;
  settings.spp = 16;
  settings.subsurface = false;
  const auto lights = prepare_lights({white_environment()}, {});
  const auto a = render_lights(
      {*build_scene(plane_model(1000, constant_set(with))), *lights, narrow_camera(500), 0}, settings);
  const auto b = render_lights(
      {*build_scene(plane_model(1000, constant_set(without))), *lights, narrow_camera(500), 0}, settings);
  EXPECT_EQ(a[0].radiance.values, b[0].radiance.values);
}

}  // namespace
}  // namespace ohb
