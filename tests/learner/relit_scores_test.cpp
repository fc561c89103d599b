// Reliefs of maps, and scores of their path-traced pictures.
#include "learner/relit_scores.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "learner/relief.h"
#include "test_samples.h"
#include "tests/support/paths.h"
#include "tests/support/test_files.h"

namespace ohb {
using namespace learner;
using namespace renderer;
namespace {

using torch::Tensor;

constexpr int kSize_px = 24;

struct Ball {
  Sample sample = ball_sample(kSize_px, "ball", 0);
  Example example = example_of(sample, "ball.exr", 0, kSize_px);
  Camera camera = camera_of(sample, "ball.exr");

  Model relief(const MaterialMaps& maps, float jump_cm = kDepthJump_cm) const {
    return relief_of(maps, example.mask, camera, example.half_frame_cm, jump_cm);
  }
};

/// The largest displacement of the neighbours, in cm.
float nearest_around(const Sample& sample, int x, int y) {
  float nearest = -1e9f;
  for (int j = std::max(0, y - 1); j <= std::min(kSize_px - 1, y + 1); ++j)
    for (int i = std::max(0, x - 1); i <= std::min(kSize_px - 1, x + 1); ++i)
      if (*sample.mask.pixel(i, j) > 0) nearest = std::max(nearest, *sample.displacement.pixel(i, j));
  return nearest;
}

RelitOptions few_paths() {
  RelitOptions options;
  options.spp = 8;
  return options;
}

Psnr score_of(const Ball& ball, const MaterialMaps& estimate) {
  RelitScores scores(few_paths());
  scores.begin(ball.example, ball.camera);
  scores.add("row", estimate);
  const RelitReport report = scores.report();
  EXPECT_EQ(report.environments, (std::vector<std::string>{"studio", "sunset"}));
  EXPECT_EQ(report.rows.at(0).people.count("ball"), 1u);
  return report.rows.at(0).mean.at(0);
}

TEST(Relief, HasAVertexAPixelOnItsRayWithItsNormalAndTexel) {
  const Ball ball;
  const Model relief = ball.relief(ball.example.truth, 1e6f);
  ASSERT_EQ(relief.normals.size(), relief.positions_cm.size());
  ASSERT_EQ(relief.uvs.size(), relief.positions_cm.size());
  std::set<int> covered;
  for (size_t i = 0; i < relief.positions_cm.size(); ++i) {
    const Vec3f p = relief.positions_cm[i], n = relief.normals[i];
    const float scale = ball.camera.half_width * (ball.camera.distance_cm - p.z);
    const float u = 0.5f + 0.5f * p.x / scale, v = 0.5f - 0.5f * (p.y - ball.camera.center_y_cm) / scale;
    const int x = static_cast<int>(u * kSize_px), y = static_cast<int>(v * kSize_px);
    EXPECT_NEAR(u * kSize_px, x + 0.5, 1e-3);
    EXPECT_NEAR(v * kSize_px, y + 0.5, 1e-3);
    if (*ball.sample.mask.pixel(x, y) == 0) {  // beside the outline
      EXPECT_LT(p.z, nearest_around(ball.sample, x, y) - 1) << "goes on behind it";
      continue;
    }
    covered.insert(y * kSize_px + x);
    EXPECT_NEAR(p.z, *ball.sample.displacement.pixel(x, y), 1e-3);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(n[c], ball.sample.normal.pixel(x, y)[c], 1e-5);
    EXPECT_NEAR(relief.uvs[i].x, u, 1e-5);
    EXPECT_NEAR(relief.uvs[i].y, 1 - v, 1e-5);
  }
  const auto& mask = ball.sample.mask.values;
  EXPECT_EQ(covered.size(), static_cast<size_t>(std::count(mask.begin(), mask.end(), 1.0f)));
  EXPECT_EQ(relief.sets.at(0).albedo.values, ball.sample.diffuse.values);
  EXPECT_EQ(relief.sets.at(0).specular.values, ball.sample.specular.values);
}

TEST(Relief, HasNoSheetAcrossADepthJumpAndNoCrack) {
  Ball ball;
  ball.example.truth.displacement.slice(3, 0, kSize_px / 2).sub_(0.3);  // the left half, 30 cm behind
  const Model relief = ball.relief(ball.example.truth);
  for (const ModelTriangle& triangle : relief.triangles) {
    float low = 1e9f, high = -1e9f;
    for (const uint32_t p : triangle.position) {
      low = std::min(low, relief.positions_cm[p].z);
      high = std::max(high, relief.positions_cm[p].z);
    }
    EXPECT_LE(high - low, kDepthJump_cm);
  }
  RenderSettings settings;
  settings.size_px = kSize_px;
  const Sample seen = render_maps(*build_scene(relief), ball.camera, 0, settings);
  for (size_t p = 0; p < seen.mask.values.size(); ++p)
    EXPECT_GE(seen.mask.values[p], ball.sample.mask.values[p]) << p;
}

TEST(Relief, HasNoIsolatedPits) {
  constexpr float kUncut = 1e6f;  // the same vertices in all
  Ball ball;
  const Tensor displacement = ball.example.truth.displacement;
  const int middle = kSize_px / 2;
  const Model whole = ball.relief(ball.example.truth, kUncut);
  displacement.slice(2, middle, middle + 2).slice(3, middle, middle + 1).sub_(0.2);  // two pixels
  const Model mended = ball.relief(ball.example.truth, kUncut);
  displacement.slice(2, middle, middle + 2).slice(3, middle, middle + 1).add_(0.2);
  displacement.slice(3, middle, middle + 1).sub_(0.2);  // a furrow from top to bottom is no pit
  const Model furrow = ball.relief(ball.example.truth, kUncut);
  ASSERT_EQ(mended.positions_cm.size(), whole.positions_cm.size());
  ASSERT_EQ(furrow.positions_cm.size(), whole.positions_cm.size());
  const float deep_cm = 0.2f * static_cast<float>(ball.example.half_frame_cm);
  int deeper = 0;
  for (size_t i = 0; i < whole.positions_cm.size(); ++i) {
    EXPECT_NEAR(mended.positions_cm[i].z, whole.positions_cm[i].z, 0.25f * deep_cm) << i;
    deeper += furrow.positions_cm[i].z < whole.positions_cm[i].z - 0.9f * deep_cm ? 1 : 0;
  }
  EXPECT_GT(deeper, kSize_px / 2);
}

TEST(RelitScores, OfTheTruthAreTheMost) {
  const Ball ball;
  const Psnr score = score_of(ball, ball.example.truth);
  EXPECT_EQ(score.masked, 100);
  EXPECT_EQ(score.full, 100);
}

TEST(RelitScores, FallWithTheError) {
  const Ball ball;
  MaterialMaps near = ball.example.truth, far = ball.example.truth, bent = ball.example.truth;
  near.diffuse = near.diffuse * 1.1;
  far.diffuse = far.diffuse * 1.3;
  bent.normal = torch::zeros_like(bent.normal);
  bent.normal.select(1, 2).fill_(1);
  const double one = score_of(ball, near).masked, three = score_of(ball, far).masked;
  EXPECT_LT(one, 50);
  EXPECT_LT(three, one - 6) << "three times the error is 9.5 dB, less where sRGB compresses it";
  EXPECT_LT(score_of(ball, bent).masked, 40);
  EXPECT_GT(score_of(ball, near).full, one) << "the empty part of the frame has no error";
}

TEST(RelitScores, OfBrokenMapsAreNoNumbers) {
  Ball ball;
  MaterialMaps broken = ball.example.truth;
  broken.displacement = broken.displacement.clone();
  broken.displacement[0][0][kSize_px / 2][kSize_px / 2] = std::nanf("");
  EXPECT_TRUE(std::isnan(score_of(ball, broken).masked));
  broken.diffuse = torch::full_like(broken.diffuse, INFINITY);
  EXPECT_TRUE(std::isnan(score_of(ball, broken).masked)) << "nothing is left";
  ball.example.mask.zero_();
  EXPECT_TRUE(std::isnan(score_of(ball, ball.example.truth).masked)) << "an empty mask";
  EXPECT_TRUE(json_number(std::nan("")).is_null());
  EXPECT_EQ(table_cell(std::nan("")), "      - |");
}

TEST(RelitScores, NamesEnvironmentsAndWhatIsWrong) {
  TemporaryFolder folder;
  RelitOptions options = few_paths();
  const std::string sunset = source_path("assets/environments/sunset.exr");
  options.environments = {sunset, sunset};
  expect_message(input_error_of([&] { RelitScores{options}; }), {"sunset.exr", "named 'sunset' too"});
  options.environments = {folder / "none.exr"};
  expect_message(input_error_of([&] { RelitScores{options}; }), {"none.exr"});
  Sample sample = ball_sample(kSize_px, "ball", 0);
  for (auto& [name, value] : sample.attributes)
    if (name == "ohb:cameraDistance_cm") value = "far";
  expect_message(input_error_of([&] { camera_of(sample, "ball.exr"); }),
                 {"ball.exr", "ohb:cameraDistance_cm", "'far'"});
}

TEST(RelitViews, AreEvenlySpacedAndTakeTheLightsInTurn) {
  Dataset dataset;
  dataset.people = {{"ada", {"a0", "a1", "a2", "a3", "a4"}}, {"bob", {"b0"}}};
  using Views = std::map<std::filesystem::path, uint64_t>;
  EXPECT_EQ(relit_views(dataset, {"ada", "bob"}, 2), (Views{{"a0", 0}, {"a2", 1}, {"b0", 0}}));
  EXPECT_EQ(relit_views(dataset, {"bob"}, 9), (Views{{"b0", 0}}));
  EXPECT_TRUE(relit_views(dataset, {"ada"}, 0).empty());
}

}  // namespace
}  // namespace ohb
