// Small scenes in Cycles 3.4 and here, one new feature a step, so that the step that fails names its cause.
// Needs Blender (packages.txt).
#include "cycles_ladder.h"

namespace ohb {
using namespace renderer;
using namespace validation;
namespace {

void expect_equal(const Ladder& ladder) {
  expect_equal(ladder, find_blender({}));
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
  const Image our_whole = render_lights({*built, *lights, scene.camera, 0}, settings)[0].radiance;
  settings.crop = boxes[0];
  const Image our_part = render_lights({*built, *lights, scene.camera, 0}, settings)[0].radiance;
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

// The .blend of `validate --keep-scene`, with nothing else left of the scene, renders the same pixels.
TEST(CyclesScene, TheKeptSceneRendersTheSamePicture) {
  TextureSet set = plain_set();
  set.albedo = noise_map(3, 0.1f, 0.9f, 5);
  set.specular = constant_map(1, {0.25f});  // Cycles 3.4 reads 0 as another number from a file of halves
  const Model model = ball(set, 0.3f);
  const Environment environment = uneven_environment();
  const TemporaryFolder folder;
  CyclesScene scene;
  scene.model = &model;
  scene.environment = &environment;
  scene.camera = fit_camera(model.positions_cm);
  scene.size_px = 24;
  scene.passes = {{4, {77}, {}}};
  scene.kept = "kept.blend";
  write_cycles_scene(folder / "scene", scene);
  const Blender blender = find_blender({});
  const CyclesRun run = run_cycles(blender, folder / "scene", 1);
  std::filesystem::rename(folder / "scene/renders/kept.blend", folder / "kept.blend");
  std::filesystem::remove_all(folder / "scene");
  const ProcessResult again = run_process({blender.program.string(), "-b", "-noaudio", "--factory-startup",
                                           folder / "kept.blend", "-o", folder / "again_#", "-f", "1"},
                                          {}, nullptr);
  ASSERT_EQ(again.exit_code, 0) << reason_of(again.last_lines);
  const Image same = read_image(folder / "again_1.exr"), &first = run.passes.at(0).at(0).rgba;
  ASSERT_EQ(same.values.size(), first.values.size());
  for (size_t i = 0; i < first.values.size(); ++i) ASSERT_NEAR(same.values[i], first.values[i], 1e-5) << i;
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

TEST(CyclesLadder, SubsurfaceSheetLitFromBehind) {
  expect_equal(sheet_lit_from_behind());
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
