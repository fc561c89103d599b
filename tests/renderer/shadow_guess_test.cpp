// Guessing shadows changes what rays are sent, not what the picture is.
#include "renderer/shadow_guess.h"

#include <gtest/gtest.h>

#include <cmath>

#include "renderer/render.h"
#include "sky_with_sun.h"

namespace ohb {
using namespace renderer;
namespace {

TEST(DirectionCells, DirectionsLieInTheirCells) {
  for (int cell = 0; cell < DirectionCells::kCount; ++cell)
    for (const float u : {0.01f, 0.3f, 0.99f})
      for (const float v : {0.01f, 0.7f, 0.99f})
        ASSERT_EQ(DirectionCells::cell_of(DirectionCells::direction(cell, u, v)), cell) << u << " " << v;
  for (const Vec3f axis : {Vec3f{0, -1, 0}, Vec3f{1, 0, 0}, Vec3f{0, 0, -1}, Vec3f{-0.0f, -1, -0.0f}}) {
    EXPECT_GE(DirectionCells::cell_of(axis), 0);
    EXPECT_LT(DirectionCells::cell_of(axis), DirectionCells::kCount);
  }
}

TEST(ShadowGuess, IsNeverCertainAndDoubtsLessTheMoreItSaw) {
  ShadowGuess guess;
  uint8_t cells[8] = {0, 1, 2, 3, 4, 5, 6, 255};
  const Expected8 none = guess.expect(cells);
  EXPECT_FLOAT_EQ(none.share[7], 0.5f);
  EXPECT_FLOAT_EQ(none.doubt[7], 0.5f);
  for (int i = 0; i < 100; ++i) guess.at(1).add(1), guess.at(2).add(0), guess.at(255).add(i % 2);
  for (int i = 0; i < 10000; ++i) guess.at(3).add(1);
  const Expected8 some = guess.expect(cells);
  EXPECT_NEAR(some.share[1], 1, 0.01);
  EXPECT_NEAR(some.share[2], 0, 0.01);
  EXPECT_FLOAT_EQ(some.share[7], 0.5f);
  EXPECT_GT(some.doubt[3], 0);
  EXPECT_LT(some.doubt[3], some.doubt[1]);
  EXPECT_FLOAT_EQ(some.doubt[0], 0.5f);
}

/// A wall behind bars: where bars are narrow against four pixels, what one pixel finds says little of the
/// next.
Model barred_wall(int bars, float gap_cm, const TextureSet& set) {
  Model model = plane_model(100, set);
  const float pitch_cm = 100.0f / static_cast<float>(bars);
  for (int b = 0; b < bars; ++b) {
    const auto first = static_cast<uint32_t>(model.positions_cm.size());
    for (int corner = 0; corner < 4; ++corner) {
      const float x = pitch_cm * (static_cast<float>(b) + 0.5f * static_cast<float>(corner & 1)) - 50;
      model.positions_cm.push_back({x, corner < 2 ? 0.0f : 100.0f, gap_cm});
      model.uvs.push_back({0.5f, 0.5f});
    }
    model.triangles.push_back(triangle_of(first, first + 1, first + 3));
    model.triangles.push_back(triangle_of(first, first + 3, first + 2));
  }
  for (size_t t = 0; t < model.triangles.size(); ++t)
    model.triangles[t].source_face = static_cast<uint32_t>(t);
  return model;
}

/// A sheet that lets half of the light through, cut away from the model's right half.
Model half_shaded_wall(const TestMaterial& material) {
  TextureSet set = constant_set(material);
  set.alpha = set.roughness;
  for (float& v : set.alpha.values) v = 1;
  Model model = plane_model(100, set);
  TextureSet sheet = set;
  for (float& v : sheet.alpha.values) v = 0.5f;
  model.sets.push_back(sheet);
  const auto first = static_cast<uint32_t>(model.positions_cm.size());
  for (const Vec3f p : {Vec3f{-60, 0, 30}, Vec3f{0, 0, 30}, Vec3f{0, 100, 30}}) {
    model.positions_cm.push_back(p);
    model.uvs.push_back({0.5f, 0.5f});
  }
  model.triangles.push_back(triangle_of(first, first + 1, first + 2, 1));
  return model;
}

struct Stacks {
  std::vector<std::vector<float>> guessed, asked;  // image by image
  double guessed_rays = 0, asked_rays = 0;
  size_t below_0 = 0;
};

Stacks render_both(const Model& model, RenderSettings settings, int images, float sun = 300) {
  const auto scene = build_scene(model);
  const auto lights = prepare_lights({sky_with_sun(sun)}, {});
  Stacks stacks;
  for (int k = 0; k < images; ++k)
    for (const bool guesses : {true, false}) {
      settings.guess_shadows = guesses;
      settings.seed = static_cast<uint64_t>(100 + 2 * k + guesses);
      RenderStatistics statistics;
      (guesses ? stacks.guessed : stacks.asked)
          .push_back(
              render_lights({*scene, *lights, fit_camera(model.positions_cm), 0}, settings, &statistics)[0]
                  .radiance.values);
      (guesses ? stacks.guessed_rays : stacks.asked_rays) += static_cast<double>(statistics.shadow_rays);
    }
  for (const std::vector<float>& image : stacks.guessed)
    for (const float value : image) stacks.below_0 += value < 0;
  return stacks;
}

/// Sum over the pixels of the variance over the images.
double variance(const std::vector<std::vector<float>>& images) {
  double total = 0;
  const auto n = static_cast<double>(images.size());
  for (size_t i = 0; i < images[0].size(); ++i) {
    double sum = 0, squares = 0;
    for (const auto& image : images) sum += image[i], squares += double{image[i]} * image[i];
    total += (squares - sum * sum / n) / (n - 1);
  }
  return total;
}

/// Means of 8 x 8 pixels equal each other: Z-values over the blocks, whose squares add up to chi-squared.
void expect_equal_means(const Stacks& stacks, int size_px) {
  constexpr int kBlock = 8;
  const int blocks = size_px / kBlock;
  double chi2 = 0;
  int count = 0;
  for (int b = 0; b < blocks * blocks; ++b) {
    double mean[2] = {}, squared_error[2] = {};
    for (int side = 0; side < 2; ++side) {
      const auto& images = side ? stacks.guessed : stacks.asked;
      double sum = 0, squares = 0;
      for (const auto& image : images) {
        double of_block = 0;
        for (int i = 0; i < kBlock * kBlock; ++i)
          of_block += image[3 * static_cast<size_t>((b / blocks * kBlock + i / kBlock) * size_px +
                                                    b % blocks * kBlock + i % kBlock)];
        sum += of_block, squares += of_block * of_block;
      }
      const auto n = static_cast<double>(images.size());
      mean[side] = sum / n;
      squared_error[side] = (squares / n - mean[side] * mean[side]) / (n - 1);
    }
    if (!(squared_error[0] + squared_error[1] > 0)) continue;
    chi2 += std::pow(mean[0] - mean[1], 2) / (squared_error[0] + squared_error[1]);
    ++count;
  }
  ASSERT_GT(count, 10);
  // Squares of Student's t: four standard deviations of their sum.
  const double dof = static_cast<double>(stacks.guessed.size() + stacks.asked.size()) - 2;
  const double mean = dof / (dof - 2), squared = 2 * mean * mean * (dof - 1) / (dof - 4);
  EXPECT_LT(chi2, mean * count + 4 * std::sqrt(squared * count));
}

RenderSettings small(int spp = 16) {
  RenderSettings settings;
  settings.size_px = 32;
  settings.spp = spp;
  return settings;
}

TEST(ShadowGuess, IsUnbiased) {
  const TestMaterial rough{{0.7f, 0.5f, 0.3f}, 0.6f, 0.2f}, skin{{0.7f, 0.5f, 0.3f}, 0.5f, 0.2f, 1};
  for (const bool adaptive : {false, true})
    for (const TestMaterial& material : {rough, skin}) {
      RenderSettings settings = small();
      settings.adaptive = adaptive;
      expect_equal_means(render_both(barred_wall(6, 10, constant_set(material)), settings, 32), 32);
    }
}

TEST(ShadowGuess, IsUnbiasedBehindCutOutsAndLayers) {
  RenderSettings settings = small();
  expect_equal_means(render_both(half_shaded_wall({{0.7f, 0.5f, 0.3f}, 0.6f, 0.2f}), settings, 64), 32);
  settings.shading = ShadingModel::kV2;
  expect_equal_means(render_both(half_shaded_wall({{0.7f, 0.5f, 0.3f}, 0.2f, 0.5f}), settings, 64), 32);
}

TEST(ShadowGuess, AsksLessWhereNothingIsInDoubt) {
  // A ball shades itself only: what is above its horizon is free.
  const Stacks stacks = render_both(sphere_model(50, 64, constant_set({})), small(64), 16);
  EXPECT_LT(stacks.guessed_rays, 0.65 * stacks.asked_rays);
  EXPECT_LT(variance(stacks.guessed), 1.05 * variance(stacks.asked));
  EXPECT_EQ(stacks.below_0, 0u);
}

TEST(ShadowGuess, WhereItKnowsNothingItDoesNoHarm) {
  // Shadows narrower than a pixel, and as wide as two: each pixel's neighbours find something else.
  for (const int bars : {100, 8})
    for (const float sun : {300.0f, 1e6f}) {
      const Stacks stacks = render_both(barred_wall(bars, 5, constant_set({})), small(64), 16, sun);
      EXPECT_LT(variance(stacks.guessed) * stacks.guessed_rays,
                1.2 * variance(stacks.asked) * stacks.asked_rays)
          << bars << " bars, sun " << sun;
      EXPECT_LT(stacks.below_0, stacks.guessed.size() * stacks.guessed[0].size() / 1000);
      for (const std::vector<float>& image : stacks.guessed)
        for (const float value : image) ASSERT_TRUE(std::isfinite(value));
    }
}

TEST(ShadowGuess, ACropIsThosePixels) {
  const Model model = barred_wall(8, 5, constant_set({}));
  const auto scene = build_scene(model);
  const auto lights = prepare_lights({sky_with_sun(300)}, {});
  RenderSettings settings = small();
  const Camera camera = fit_camera(model.positions_cm);
  const Image whole = render_lights({*scene, *lights, camera, 0}, settings)[0].radiance;
  settings.crop = {9, 6, 23, 19};
  const Image part = render_lights({*scene, *lights, camera, 0}, settings)[0].radiance;
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 32; ++x)
      for (int c = 0; c < 3; ++c)
        ASSERT_EQ(part.pixel(x, y)[c], x >= 9 && x < 23 && y >= 6 && y < 19 ? whole.pixel(x, y)[c] : 0)
            << x << " " << y;
}

}  // namespace
}  // namespace ohb
