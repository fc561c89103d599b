// Small scenes in Cycles 3.4 and here, one new feature a step, so that the step that fails names its cause.
// Needs Blender (packages.txt).
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "renderer/validation/cycles_run.h"
#include "renderer/validation/cycles_scene.h"
#include "renderer/validation/statistics.h"
#include "tests/support/test_files.h"

namespace ohb {
namespace {

constexpr float kTau = 6.2831853f;

Image constant_map(int channels, std::initializer_list<float> values) {
  Image image(8, 8, channels);
  for (size_t i = 0; i < image.values.size(); ++i) image.values[i] = *(values.begin() + i % channels);
  return image;
}

/// Random texels between low and high.
Image noise_map(int channels, float low, float high, uint32_t seed, int size_px = 8) {
  Image image(size_px, size_px, channels);
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> value(low, high);
  for (float& v : image.values) v = value(random);
  return image;
}

/// Unit normals tilted by up to about `tilt`.
Image noise_normals(float tilt, uint32_t seed) {
  Image image = noise_map(3, -tilt, tilt, seed);
  for (size_t i = 0; i < image.values.size(); i += 3) {
    const Vec3f n = normalised({image.values[i], image.values[i + 1], 1});
    image.values[i] = n.x, image.values[i + 1] = n.y, image.values[i + 2] = n.z;
  }
  return image;
}

TextureSet plain_set() {
  TextureSet set;
  set.name = "set";
  set.albedo = constant_map(3, {0.8f, 0.4f, 0.1f});
  set.roughness = constant_map(1, {0.5f});
  set.specular = constant_map(1, {0});
  set.sss = constant_map(1, {0});
  return set;
}

/// A bumpy ball of 24 x 16 quads, radius about 10 cm, standing on y = 0; seam, poles and a mirrored half.
void add_ball(Model& model, uint16_t set, Vec3f centre, float radius, float bumps = 0) {
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

Model ball(const TextureSet& set, float bumps = 0) {
  Model model;
  model.sets = {set};
  add_ball(model, 0, {0, 10, 0}, 10, bumps);
  return model;
}

/// A square card of 2 x 2 quads facing +Z.
void add_card(Model& model, uint16_t set, Vec3f centre, float half_width) {
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

Environment constant_environment() {
  Environment environment;
  environment.name = "constant";
  environment.radiance = Image(64, 32, 3);
  for (float& v : environment.radiance.values) v = 1;
  return environment;
}

/// Uneven everywhere, in three unequal channels.
Environment uneven_environment() {
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
Environment sunny_environment() {
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
};

struct Comparison {
  RegionRatio all, inside;
  BinTest bins;
  CyclesRun cycles;
};

Comparison compare(const Ladder& ladder) {
  constexpr int kSeeds = 8;
  const TemporaryFolder folder;
  CyclesScene scene;
  scene.model = &ladder.model;
  scene.environment = ladder.environment.radiance.values.empty() ? nullptr : &ladder.environment;
  scene.points = ladder.points;
  scene.camera = fit_camera(ladder.model.positions_cm);
  scene.turn_rad = ladder.turn_rad;
  scene.size_px = ladder.size_px;
  scene.max_bounces = ladder.max_bounces;
  scene.subsurface = ladder.subsurface;
  scene.passes = {{ladder.spp, cycles_seeds(1, kSeeds), {}}};
  write_cycles_scene(folder.path(), scene);
  Comparison result;
  result.cycles = run_cycles(find_blender({}), folder.path(), 2);
  ImageStack theirs, ours;
  for (const CyclesRender& render : result.cycles.passes.at(0)) theirs.push_back(render.rgba);

  const auto built = build_scene(ladder.model);
  std::vector<Environment> environments;
  if (scene.environment) environments.push_back(ladder.environment);
  const auto lights = prepare_lights(environments, ladder.points);
  RenderSettings settings;
  settings.size_px = ladder.size_px;
  settings.spp = ladder.spp;
  settings.max_bounces = ladder.max_bounces;
  settings.subsurface = ladder.subsurface;
  settings.first_sample_at_centre = true;
  for (int k = 0; k < kSeeds; ++k) {
    settings.seed = 1000 + k;
    std::vector<SampleLight> images = render_lights(*built, *lights, scene.camera, ladder.turn_rad, settings);
    for (size_t l = 1; l < images.size(); ++l)
      for (size_t i = 0; i < images[0].radiance.values.size(); ++i)
        images[0].radiance.values[i] += images[l].radiance.values[i];
    ours.push_back(images[0].radiance);
  }
  const PixelSets sets =
      pixel_sets(render_maps(*built, scene.camera, ladder.turn_rad, settings).mask, theirs[0]);
  result.all = compare_region("all", ours, theirs, std::vector<float>(sets.foreground.size(), 1.0f));
  result.inside =
      compare_region("inside", ours, theirs, std::vector<float>(sets.inside.begin(), sets.inside.end()));
  result.bins = test_bins(ours, theirs, sets.inside);
  return result;
}

void expect_equal(const Ladder& ladder, double tolerance = 0.003) {
  const Comparison result = compare(ladder);
  for (const CyclesSetting& setting : result.cycles.settings)
    EXPECT_TRUE(setting.same) << setting.name << ": wanted " << setting.wanted << ", found " << setting.found;
  for (const RegionRatio* region : {&result.all, &result.inside}) {
    EXPECT_GT(region->total.high, 1 - tolerance) << region->name;
    EXPECT_LT(region->total.low, 1 + tolerance) << region->name;
    EXPECT_NEAR(region->total.value, 1, 2 * tolerance) << region->name;
    std::printf("  %s ratio %.5f [%.5f, %.5f], R %.5f G %.5f B %.5f; mean %.4f\n", region->name.c_str(),
                region->total.value, region->total.low, region->total.high, region->channel[0].value,
                region->channel[1].value, region->channel[2].value, region->mean_b[0]);
  }
  std::printf("  bins %zu of %zu accepted, p < .05: %.3f, detectable %.3f\n", result.bins.accepted,
              result.bins.bins, result.bins.below_5_percent, result.bins.median_detectable);
  EXPECT_GE(result.bins.accepted_share, 0.995);
}

// Boxes are the same pixels in both, also where the frame is no power of two.
TEST(CyclesScene, BoxesAreThosePixelsOfTheWholeImage) {
  constexpr int kSize = 50;
  const Model model = ball(plain_set());
  const Environment environment = uneven_environment();
  const std::vector<PixelBox> boxes = {{11, 7, 30, 20}, {33, 30, 50, 50}};
  const TemporaryFolder folder;
  CyclesScene scene;
  scene.model = &model;
  scene.environment = &environment;
  scene.camera = fit_camera(model.positions_cm);
  scene.size_px = kSize;
  scene.passes = {{4, {77}, {}}, {4, {77}, boxes}};
  write_cycles_scene(folder.path(), scene);
  const CyclesRun run = run_cycles(find_blender({}), folder.path(), 1);
  const Image &whole = run.passes.at(0).at(0).rgba, &part = run.passes.at(1).at(0).rgba;

  const auto built = build_scene(model);
  const auto lights = prepare_lights({environment}, {});
  RenderSettings settings;
  settings.size_px = kSize;
  settings.spp = 4;
  const Image our_whole = render_lights(*built, *lights, scene.camera, 0, settings)[0].radiance;
  settings.crop = boxes[0];
  const Image our_part = render_lights(*built, *lights, scene.camera, 0, settings)[0].radiance;
  const auto inside = [](const PixelBox& b, int x, int y) {
    return x >= b.x0 && x < b.x1 && y >= b.y0 && y < b.y1;
  };
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const bool in_boxes = inside(boxes[0], x, y) || inside(boxes[1], x, y);
      for (int c = 0; c < 4; ++c)
        ASSERT_EQ(part.pixel(x, y)[c], in_boxes ? whole.pixel(x, y)[c] : 0) << x << " " << y;
      for (int c = 0; c < 3; ++c)
        ASSERT_EQ(our_part.pixel(x, y)[c], inside(boxes[0], x, y) ? our_whole.pixel(x, y)[c] : 0);
    }
}

TEST(CyclesLadder, DiffuseBallConstantLight) {
  expect_equal({ball(plain_set()), constant_environment()});
}

TEST(CyclesLadder, BumpyBallInterreflects) {
  expect_equal({ball(plain_set(), 0.3f), sunny_environment()});
}

TEST(CyclesLadder, Turned) {
  Ladder ladder{ball(plain_set(), 0.3f), uneven_environment()};
  ladder.turn_rad = 1;
  expect_equal(ladder);
}

TEST(CyclesLadder, AlbedoMap) {
  TextureSet set = plain_set();
  set.albedo = noise_map(3, 0, 1, 5);
  expect_equal({ball(set), uneven_environment()});
}

TEST(CyclesLadder, Specular) {
  TextureSet set = plain_set();
  set.specular = constant_map(1, {0.25f});
  expect_equal({ball(set, 0.3f), uneven_environment()});
}

TEST(CyclesLadder, SpecularAndRoughnessMaps) {
  TextureSet set = plain_set();
  set.specular = noise_map(1, 0, 0.6f, 6);
  set.roughness = noise_map(1, 0.2f, 1, 7);
  expect_equal({ball(set), uneven_environment()});
}

TEST(CyclesLadder, NormalMapDiffuse) {
  TextureSet set = plain_set();
  set.normal = noise_normals(0.7f, 8);
  expect_equal({ball(set), uneven_environment()});
}

TEST(CyclesLadder, NormalMapSpecular) {
  TextureSet set = plain_set();
  set.normal = noise_normals(0.7f, 8);
  set.specular = constant_map(1, {0.4f});
  set.roughness = constant_map(1, {0.3f});
  expect_equal({ball(set, 0.3f), sunny_environment()});
}

// Directions between the geometric and the tilted horizon: Cycles keeps those that the highlight sampled.
TEST(CyclesLadder, NormalMapHighlightsOnly) {
  TextureSet set = plain_set();
  set.albedo = constant_map(3, {0, 0, 0});
  set.normal = noise_normals(0.7f, 8);
  set.specular = constant_map(1, {0.4f});
  set.roughness = constant_map(1, {0.3f});
  expect_equal({ball(set), constant_environment()});
}

Ladder subsurface_ball(const TextureSet& set, float bumps, const Environment& environment) {
  Ladder ladder{ball(set, bumps), environment};
  ladder.subsurface = true;
  return ladder;
}

TEST(CyclesLadder, SubsurfaceBallConstantLight) {
  TextureSet set = plain_set();
  set.sss = constant_map(1, {0.5f});
  expect_equal(subsurface_ball(set, 0, constant_environment()));
}

// Free paths of the size of the bumps: light goes through them.
TEST(CyclesLadder, SubsurfaceBumpyBallInTheSun) {
  TextureSet set = plain_set();
  set.sss = constant_map(1, {4.0f});
  expect_equal(subsurface_ball(set, 0.3f, sunny_environment()));
}

TEST(CyclesLadder, SubsurfaceUnderHighlights) {
  TextureSet set = plain_set();
  set.sss = constant_map(1, {0.3f});
  set.specular = constant_map(1, {0.45f});
  set.roughness = constant_map(1, {0.4f});
  expect_equal(subsurface_ball(set, 0.3f, uneven_environment()));
}

// Subsurface here, none there, and normals that the walks' ends ask for where they come out.
TEST(CyclesLadder, SubsurfaceMapsAndNormalMap) {
  TextureSet set = plain_set();
  set.albedo = noise_map(3, 0.05f, 0.95f, 5);
  set.sss = noise_map(1, -0.5f, 0.5f, 11);
  for (float& v : set.sss.values) v = v < 0 ? 0.0f : v + 0.1f;
  set.normal = noise_normals(0.7f, 8);
  set.specular = noise_map(1, 0, 0.6f, 6);
  set.roughness = noise_map(1, 0.2f, 1, 7);
  expect_equal(subsurface_ball(set, 0, uneven_environment()));
}

TEST(CyclesLadder, SubsurfacePointLight) {
  TextureSet set = plain_set();
  set.sss = constant_map(1, {0.5f});
  Ladder ladder = subsurface_ball(set, 0.3f, {});
  ladder.points = {{"a", {30, 40, 30}, 1.5f}};
  expect_equal(ladder);
}

// A sheet thinner than a free path, seen from both sides.
TEST(CyclesLadder, SubsurfaceThinSheet) {
  TextureSet set = plain_set();
  set.sss = constant_map(1, {1.0f});
  Model model;
  model.sets = {set};
  add_card(model, 0, {0, 10, 0}, 8);
  add_card(model, 0, {0, 10, -0.2f}, 8);
  Ladder ladder{model, sunny_environment()};
  ladder.subsurface = true;
  expect_equal(ladder);
}

TEST(CyclesLadder, CutOutCards) {
  TextureSet set = plain_set();
  set.alpha = noise_map(1, -0.5f, 1.5f, 9);
  for (float& v : set.alpha.values) v = std::min(1.0f, std::max(0.0f, v));
  Model model;
  model.sets = {set, plain_set()};
  for (int i = 0; i < 4; ++i) add_card(model, 0, {0.0f + i, 10, 3.0f * i}, 8);
  add_ball(model, 1, {0, 10, -8}, 7);
  expect_equal({model, sunny_environment()});
}

TEST(CyclesLadder, PointLights) {
  Ladder ladder{ball(plain_set(), 0.3f), {}};
  ladder.points = {{"a", {30, 40, 30}, 1.5f}, {"b", {-30, 5, 10}, 0.5f}};
  ladder.turn_rad = 2;
  expect_equal(ladder);
}

}  // namespace
}  // namespace ohb
