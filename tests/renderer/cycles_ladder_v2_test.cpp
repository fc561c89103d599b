// Small scenes in Cycles 4.5 and here with Principled v2, one new feature a step. Needs Blender 4.5 as a
// Python module: OHB_BPY names its virtual environment (docs/commands/validate.md says how to make one);
// without it the tests are skipped.
#include <cstdlib>

#include "cycles_ladder.h"

namespace ohb {
using namespace renderer;
using namespace validation;
namespace {

class CyclesLadderV2 : public testing::Test {
 protected:
  void SetUp() override {
    const char* environment = std::getenv("OHB_BPY");
    if (!environment) GTEST_SKIP() << "OHB_BPY does not name an environment with bpy 4.5";
    blender_ = find_bpy(environment, ShadingModel::kV2);
  }

  void expect_equal(Ladder ladder) const {
    ladder.shading = ShadingModel::kV2;
    ladder.spp = 256;
    ohb::expect_equal(ladder, blender_);
  }

 private:
  Blender blender_;
};

Ladder subsurface_ball(const TextureSet& set, float bumps, const Environment& environment) {
  Ladder ladder{ball(set, bumps), environment};
  ladder.subsurface = true;
  return ladder;
}

TEST_F(CyclesLadderV2, DiffusePlaneConstantLight) {
  Model model;
  model.sets = {plain_set()};
  add_card(model, 0, {0, 10, 0}, 8);
  expect_equal({model, constant_environment()});
}

TEST_F(CyclesLadderV2, DiffuseBallInterreflects) {
  expect_equal({ball(plain_set(), 0.3f), sunny_environment()});
}

TEST_F(CyclesLadderV2, Specular) {
  TextureSet set = plain_set();
  set.specular = constant_map(1, {0.25f});
  expect_equal({ball(set, 0.3f), uneven_environment()});
}

// Highlights alone, where what is made up for several bounces between facets is half of the light.
TEST_F(CyclesLadderV2, RoughHighlightsOnly) {
  TextureSet set = plain_set();
  set.albedo = constant_map(3, {0, 0, 0});
  set.specular = constant_map(1, {0.95f});
  set.roughness = noise_map(1, 0.6f, 1, 7);
  expect_equal({ball(set), uneven_environment()});
}

// White below a highlight: the layer's weight decides.
TEST_F(CyclesLadderV2, WhiteBelowHighlights) {
  TextureSet set = plain_set();
  set.albedo = constant_map(3, {1, 1, 1});
  set.specular = noise_map(1, 0.1f, 0.7f, 6);
  set.roughness = noise_map(1, 0.1f, 1, 7);
  expect_equal({ball(set), uneven_environment()});
}

TEST_F(CyclesLadderV2, NormalMapDiffuse) {
  TextureSet set = plain_set();
  set.normal = noise_normals(0.7f, 8);
  expect_equal({ball(set), uneven_environment()});
}

TEST_F(CyclesLadderV2, NormalMapSpecular) {
  TextureSet set = plain_set();
  set.normal = noise_normals(0.7f, 8);
  set.specular = constant_map(1, {0.4f});
  set.roughness = constant_map(1, {0.3f});
  expect_equal({ball(set, 0.3f), sunny_environment()});
}

TEST_F(CyclesLadderV2, SubsurfaceBallConstantLight) {
  TextureSet set = plain_set();
  set.sss = constant_map(1, {0.5f});
  expect_equal(subsurface_ball(set, 0, constant_environment()));
}

TEST_F(CyclesLadderV2, SubsurfaceUnderHighlights) {
  TextureSet set = plain_set();
  set.sss = constant_map(1, {0.3f});
  set.specular = constant_map(1, {0.45f});
  set.roughness = constant_map(1, {0.4f});
  expect_equal(subsurface_ball(set, 0.3f, uneven_environment()));
}

// Thinner than a free path, seen from both sides.
TEST_F(CyclesLadderV2, SubsurfaceSlab) {
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

TEST_F(CyclesLadderV2, SubsurfaceSheetLitFromBehind) {
  expect_equal(sheet_lit_from_behind());
}

TEST_F(CyclesLadderV2, SubsurfacePointLight) {
  TextureSet set = plain_set();
  set.sss = constant_map(1, {0.5f});
  Ladder ladder = subsurface_ball(set, 0.3f, {});
  ladder.points = {{"a", {30, 40, 30}, 1.5f}};
  expect_equal(ladder);
}

TEST_F(CyclesLadderV2, PointLights) {
  Ladder ladder{ball(plain_set(), 0.3f), {}};
  ladder.points = {{"a", {30, 40, 30}, 1.5f}, {"b", {-30, 5, 10}, 0.5f}};
  ladder.turn_rad = 2;
  expect_equal(ladder);
}

// All maps at once: subsurface here, none there, and normals that the walks' ends ask for where they come
// out.
TEST_F(CyclesLadderV2, AllMaps) {
  TextureSet set = plain_set();
  set.albedo = noise_map(3, 0.05f, 0.95f, 5);
  set.sss = noise_map(1, -0.5f, 0.5f, 11);
  for (float& v : set.sss.values) v = v < 0 ? 0.0f : v + 0.1f;
  set.normal = noise_normals(0.7f, 8);
  set.specular = noise_map(1, 0, 0.6f, 6);
  set.roughness = noise_map(1, 0.2f, 1, 7);
  expect_equal(subsurface_ball(set, 0, uneven_environment()));
}

TEST_F(CyclesLadderV2, CutOutCards) {
  TextureSet set = plain_set();
  set.alpha = noise_map(1, -0.5f, 1.5f, 9);
  for (float& v : set.alpha.values) v = std::min(1.0f, std::max(0.0f, v));
  set.specular = constant_map(1, {0.25f});
  Model model;
  model.sets = {set, plain_set()};
  for (int i = 0; i < 4; ++i) add_card(model, 0, {0.0f + i, 10, 3.0f * i}, 8);
  add_ball(model, 1, {0, 10, -8}, 7);
  expect_equal({model, sunny_environment()});
}

}  // namespace
}  // namespace ohb
