// A flat card under a sharp sun, direct light only: an integral that a quadrature knows, so that it can tell
// which side errs. Every pixel asks for nearly the same integral, so an error that all seeds share shows.
// Needs Blender (packages.txt).
#include <Imath/half.h>

#include "cycles_ladder.h"
#include "renderer/lights.h"
#include "renderer/surface.h"

namespace ohb {
using namespace renderer;
using namespace surface;
using namespace validation;
namespace {

constexpr int kSize = 16;

Model flat_card() {
  Model model;
  model.sets = {plain_set()};
  add_card(model, 0, {0, 10, 0}, 8);
  for (Vec3f& p : model.positions_cm) p.z = 0;
  return model;
}

/// Midpoint rule over the map, 24 x 24 points a texel: radiance times solid angle of each.
std::vector<LightSample> quadrature(const EnvironmentLight& light, int width, int height) {
  constexpr int kPoints = 24;
  std::vector<LightSample> points;
  for (int y = 0; y < kPoints * height; ++y) {
    const double theta = kPi * (y + 0.5) / (kPoints * height);
    const double area = 2 * kPi * kPi * std::sin(theta) / (kPoints * width) / (kPoints * height);
    for (int x = 0; x < kPoints * width; ++x) {
      const double phi = 2 * kPi * (x + 0.5) / (kPoints * width);
      const Vec3f wi{static_cast<float>(std::sin(theta) * std::sin(phi)), static_cast<float>(std::cos(theta)),
                     static_cast<float>(std::sin(theta) * std::cos(phi))};
      if (wi.z > 0) points.push_back({wi, static_cast<float>(area) * light.at(map_place(wi)).radiance, 1});
    }
  }
  return points;
}

/// The sum of the channels' means over `pixels` in each image.
std::vector<double> sums(const ImageStack& stack, const std::vector<uint8_t>& pixels) {
  std::vector<double> sums;
  for (const Image& image : stack) {
    sums.push_back(0);
    for (size_t i = 0; i < pixels.size(); ++i)
      for (size_t c = 0; pixels[i] && c < 3; ++c)
        sums.back() += image.values[i * static_cast<size_t>(image.channels) + c];
  }
  return sums;
}

double exact_sum(const CyclesScene& scene, const std::vector<uint8_t>& pixels) {
  const EnvironmentLight light(*scene.environment);
  const Image& map = scene.environment->radiance;
  const std::vector<LightSample> points = quadrature(light, map.width_px, map.height_px);
  const ViewCamera camera(scene.camera, 0, kSize);
  const Vec3f n{0, 0, 1};
  const auto as_half = [](float value) { return static_cast<float>(half(value)); };  // as both sides hold it
  const Vec3f albedo{as_half(0.8f), as_half(0.4f), as_half(0.1f)};
  double sum = 0;
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      if (!pixels[static_cast<size_t>(y) * kSize + x]) continue;
      const Vec3f wo = -camera.ray(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f).direction;
      const PrincipledV1 bsdf({albedo, 0.5f, 0}, {n, n, n, wo}, true);
      for (const LightSample& point : points) {
        const Vec3f value = bsdf.eval(point.wi).value * point.radiance;
        sum += static_cast<double>(value.x) + value.y + value.z;
      }
    }
  return sum;
}

// Measured with 512 seeds of 100 samples, ratio to the integral and half of its 95 % interval: ours 0.9999
// and 0.0002, Cycles 3.4.1 with scrambled numbers 0.9999 and 0.0002, with its fixed tables 0.9995 and 0.0002.
// More seeds do not mend the last: the reason for CyclesNumbers.
TEST(CyclesScene, DirectLightMeetsTheIntegral) {
  const Model model = flat_card();
  const Environment environment = sunny_environment();
  CyclesScene scene;
  scene.model = &model;
  scene.environment = &environment;
  scene.camera = fit_camera(model.positions_cm);
  scene.size_px = kSize;
  scene.max_bounces = 0;
  scene.subsurface = false;
  scene.passes = {{100, cycles_seeds(1, 64), {}}};
  const OurRenderer renderer(scene);
  const Image mask = renderer.maps().mask;
  const std::vector<uint8_t> inside = pixel_sets(mask, mask).inside;
  const double exact = exact_sum(scene, inside);
  const auto expect_exact = [&](const char* name, const ImageStack& stack) {
    const std::vector<double> values = sums(stack, inside);
    const Interval ratio = ratio_of_means(values, std::vector<double>(values.size(), exact));
    std::printf("  %s %.5f [%.5f, %.5f]\n", name, ratio.value, ratio.low, ratio.high);
    EXPECT_NEAR(ratio.value, 1, 0.001) << name;
    EXPECT_LT(ratio.high - ratio.low, 0.002) << name;
  };
  const TemporaryFolder folder;
  expect_exact("ours", renderer.render(scene.passes, 1).passes.front());
  expect_exact("Cycles", render_cycles_side(scene, find_blender({}), 2, folder.path()).passes.front());
}

}  // namespace
}  // namespace ohb
