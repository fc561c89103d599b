// What the ladders to Cycles share: small scenes, each rendered there and here with several seeds.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <random>

#include "renderer/validation/focus.h"
#include "renderer/validation/sides.h"
#include "tests/support/test_files.h"

namespace ohb {
using namespace renderer;
using namespace validation;

constexpr float kTau = 6.2831853f;

inline Image constant_map(int channels, std::initializer_list<float> values) {
  Image image(8, 8, channels);
  for (size_t i = 0; i < image.values.size(); ++i) image.values[i] = *(values.begin() + i % channels);
  return image;
}

/// Random texels between low and high.
inline Image noise_map(int channels, float low, float high, uint32_t seed, int size_px = 8) {
  Image image(size_px, size_px, channels);
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> value(low, high);
  for (float& v : image.values) v = value(random);
  return image;
}

/// Unit normals tilted by up to about `tilt`.
inline Image noise_normals(float tilt, uint32_t seed) {
  Image image = noise_map(3, -tilt, tilt, seed);
  for (size_t i = 0; i < image.values.size(); i += 3) {
    const Vec3f n = normalised({image.values[i], image.values[i + 1], 1});
    image.values[i] = n.x, image.values[i + 1] = n.y, image.values[i + 2] = n.z;
  }
  return image;
}

inline TextureSet plain_set() {
  TextureSet set;
  set.name = "set";
  set.albedo = constant_map(3, {0.8f, 0.4f, 0.1f});
  set.roughness = constant_map(1, {0.5f});
  set.specular = constant_map(1, {0});
  set.sss = constant_map(1, {0});
  return set;
}

/// A bumpy ball of 24 x 16 quads, radius about 10 cm, standing on y = 0; seam, poles and a mirrored half.
inline void add_ball(Model& model, uint16_t set, Vec3f centre, float radius, float bumps = 0) {
  const int columns = 24, rows = 16;
  const uint32_t first = static_cast<uint32_t>(model.positions_cm.size());
  const uint32_t first_uv = static_cast<uint32_t>(model.uvs.size());
  for (int r = 0; r <= rows; ++r)
    for (int c = 0; c <= columns; ++c) {
      const float phi = kTau * c / columns, theta = kTau / 2 * r / rows;
      const float size = radius * (1 + bumps * std::sin(4 * phi) * std::sin(5 * theta) * std::sin(theta));
      const Vec3f p{size * std::sin(theta) * std::sin(phi), size * std::cos(theta),
                    size * std::sin(theta) * std::cos(phi)};
      if (c < columns) model.positions_cm.push_back(centre + p);
      model.uvs.push_back({2 * std::fabs(1.0f * c / columns - 0.4f), 1 - 1.0f * r / rows});
    }
  const auto add = [&](std::array<int, 6> rc) {
    ModelTriangle triangle{};
    triangle.set = set;
    for (int i = 0; i < 3; ++i) {
      triangle.position[i] = first + rc[2 * i] * columns + rc[2 * i + 1] % columns;
      triangle.uv[i] = first_uv + rc[2 * i] * (columns + 1) + rc[2 * i + 1];
    }
    model.triangles.push_back(triangle);
  };
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) {
      if (r > 0) add({r, c, r + 1, c + 1, r, c + 1});
      if (r + 1 < rows) add({r, c, r + 1, c, r + 1, c + 1});
    }
}

inline Model ball(const TextureSet& set, float bumps = 0) {
  Model model;
  model.sets = {set};
  add_ball(model, 0, {0, 10, 0}, 10, bumps);
  return model;
}

/// A square card of 2 x 2 quads facing +Z.
inline void add_card(Model& model, uint16_t set, Vec3f centre, float half_width) {
  const uint32_t first = static_cast<uint32_t>(model.positions_cm.size());
  const uint32_t first_uv = static_cast<uint32_t>(model.uvs.size());
  for (int y = 0; y <= 2; ++y)
    for (int x = 0; x <= 2; ++x) {
      model.positions_cm.push_back(centre + half_width * Vec3f{x - 1.0f, y - 1.0f, 0.2f * (x - 1) * (x - 1)});
      model.uvs.push_back({0.5f * x, 0.5f * y});
    }
  for (uint32_t y = 0; y < 2; ++y)
    for (uint32_t x = 0; x < 2; ++x) {
      const uint32_t a = 3 * y + x;
      for (const auto& corner :
           {std::array<uint32_t, 3>{a, a + 1, a + 4}, std::array<uint32_t, 3>{a, a + 4, a + 3}}) {
        ModelTriangle triangle{};
        triangle.set = set;
        for (int i = 0; i < 3; ++i) {
          triangle.position[i] = first + corner[i];
          triangle.uv[i] = first_uv + corner[i];
        }
        model.triangles.push_back(triangle);
      }
    }
}

inline Environment constant_environment() {
  Environment environment;
  environment.name = "constant";
  environment.radiance = Image(64, 32, 3);
  for (float& v : environment.radiance.values) v = 1;
  return environment;
}

/// Uneven everywhere, in three unequal channels.
inline Environment uneven_environment() {
  Environment environment;
  environment.name = "uneven";
  environment.radiance = noise_map(3, 0, 1, 3, 64);
  environment.radiance.height_px = 32;
  environment.radiance.values.resize(64 * 32 * 3);
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 64; ++x)
      for (int c = 0; c < 3; ++c)
        environment.radiance.pixel(x, y)[c] *= y < 12 + c ? 2.0f : x < 20 ? 0.2f : 1.0f;
  return environment;
}

/// The same with a small sun.
inline Environment sunny_environment() {
  Environment environment = uneven_environment();
  for (int x = 50; x < 52; ++x)
    for (int c = 0; c < 3; ++c) environment.radiance.pixel(x, 9)[c] = 100.0f + 20 * c;
  return environment;
}

struct Ladder {
  Model model;
  Environment environment;
  std::vector<PointLight> points{};
  double turn_rad = 0;
  int max_bounces = 8, spp = 100, size_px = 48;
  bool subsurface = false;
  ShadingModel shading = ShadingModel::kV1;
};

/// A sheet of skin between two faces that look away from each other, seen from before and lit from behind:
/// what arrives has gone through, far for red and near its end for blue.
inline Ladder sheet_lit_from_behind() {
  TextureSet set = plain_set();
  set.albedo = constant_map(3, {0.6f, 0.4f, 0.3f});
  set.sss = constant_map(1, {1.0f});
  Ladder ladder;
  ladder.model.sets = {set};
  add_card(ladder.model, 0, {0, 10, 0}, 8);
  const size_t front = ladder.model.triangles.size();
  add_card(ladder.model, 0, {0, 10, -0.15f}, 8);
  for (size_t t = front; t < ladder.model.triangles.size(); ++t) {
    ModelTriangle& back = ladder.model.triangles[t];
    std::swap(back.position[1], back.position[2]), std::swap(back.uv[1], back.uv[2]);
  }
  ladder.points = {{"behind", {5, 15, -40}, 20}};
  ladder.spp = 256;
  ladder.subsurface = true;
  return ladder;
}

struct Comparison {
  RegionRatio all, inside;
  BinTest bins;
  std::vector<CyclesSetting> settings;
};

inline CyclesScene cycles_scene(const Ladder& ladder) {
  CyclesScene scene;
  scene.model = &ladder.model;
  scene.environment = ladder.environment.radiance.values.empty() ? nullptr : &ladder.environment;
  scene.points = ladder.points;
  scene.camera = fit_camera(ladder.model.positions_cm);
  scene.turn_rad = ladder.turn_rad;
  scene.size_px = ladder.size_px;
  scene.max_bounces = ladder.max_bounces;
  scene.shading = ladder.shading;
  scene.subsurface = ladder.subsurface;
  return scene;
}

inline Comparison compare(CyclesScene scene, const SidesWork& work, uint64_t seed, const Blender& blender) {
  const TemporaryFolder folder;
  scene.passes = {{work.cycles_spp, cycles_seeds(seed, work.seeds), {}}};
  CyclesSide cycles = render_cycles_side(scene, blender, 2, folder.path());
  const ImageStack& theirs = cycles.passes.front();
  const OurRenderer renderer(scene);
  std::vector<CyclesPass> passes = scene.passes;
  passes.front().spp = work.our_spp;
  const ImageStack ours = std::move(renderer.render(passes, seed).passes.front());
  Comparison result;
  result.settings = std::move(cycles.settings);
  const PixelSets sets = pixel_sets(renderer.maps().mask, theirs.front());
  result.all = compare_region("all", ours, theirs, std::vector<float>(sets.foreground.size(), 1.0f));
  result.inside =
      compare_region("inside", ours, theirs, std::vector<float>(sets.inside.begin(), sets.inside.end()));
  result.bins = test_bins(ours, theirs, sets.inside);
  return result;
}

/// Up to how many times the work a rung gets if its interval is wide, as --focus of validate.
inline double most_work() {
  const char* text = std::getenv("OHB_LADDER_FOCUS");
  return text ? std::atof(text) : 1;
}

inline Comparison compare(const Ladder& ladder, const Blender& blender) {
  constexpr double kHalfWidth = 0.0007;
  const CyclesScene scene = cycles_scene(ladder);
  // A path of ours is many walks.
  const SidesWork work{8, scene.subsurface ? ladder.spp / 2 : ladder.spp, ladder.spp};
  const Comparison first = compare(scene, work, 1, blender);
  if (most_work() <= 1) return first;
  const auto width = [](const RegionRatio& region) { return region.total.high - region.total.low; };
  const RegionRatio& wider = width(first.all) > width(first.inside) ? first.all : first.inside;
  const auto more = more_work(wider.total, work, kHalfWidth, most_work(), kMaxCyclesSpp);
  return more ? compare(scene, *more, 2, blender) : first;
}

/// `tolerance` on the ratio of the means: its 95 % interval must reach into it or, where it was made narrow,
/// lie in it as a whole. `accepted`: share of the bins.
inline void expect_equal(const Ladder& ladder, const Blender& blender, double tolerance = 0.002,
                         double accepted = 0.997) {
  const Comparison result = compare(ladder, blender);
  const bool is_narrow = most_work() > 1;
  for (const CyclesSetting& setting : result.settings)
    EXPECT_TRUE(setting.same) << setting.name << ": wanted " << setting.wanted << ", found " << setting.found;
  for (const RegionRatio* region : {&result.all, &result.inside}) {
    const Interval& total = region->total;
    EXPECT_GT(is_narrow ? total.low : total.high, 1 - tolerance) << region->name;
    EXPECT_LT(is_narrow ? total.high : total.low, 1 + tolerance) << region->name;
    EXPECT_NEAR(region->total.value, 1, 2 * tolerance) << region->name;
    std::printf("  %s ratio %.5f [%.5f, %.5f], R %.5f G %.5f B %.5f; mean %.4f\n", region->name.c_str(),
                region->total.value, region->total.low, region->total.high, region->channel[0].value,
                region->channel[1].value, region->channel[2].value, region->mean_b[0]);
  }
  std::printf("  bins %zu of %zu accepted, p < .05: %.3f, detectable %.3f\n", result.bins.accepted,
              result.bins.bins, result.bins.below_5_percent, result.bins.median_detectable);
  EXPECT_GE(result.bins.accepted_share, accepted);
}

}  // namespace ohb
