// Paths where the noise is: as many as promised, in the right places, and without bias.
#include "renderer/budget.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <numeric>

#include "dataset/model/sampling.h"
#include "renderer/render.h"
#include "renderer/rounds.h"
#include "tests/support/test_models.h"

namespace ohb {
using namespace renderer;
using namespace surface;
namespace {

/// Pilots of one light whose noise is `deviation(x, y)` about 1.
template <typename Deviation>
Pilots noisy_pilots(int size_px, const Deviation& deviation) {
  Pilots pilots;
  Random random(1, 2, 3);
  for (int k = 0; k < 4; ++k) {
    Image image(size_px, size_px, 3);
    for (int y = 0; y < size_px; ++y)
      for (int x = 0; x < size_px; ++x)
        for (int c = 0; c < 3; ++c)
          image.pixel(x, y)[c] =
              1 + deviation(x, y) * 3.4641f * (random.next() - 0.5f);  // uniform, of that standard deviation
    pilots.images.push_back({{"light", image}});
  }
  return pilots;
}

TEST(AdaptiveBudget, IsProportionalToTheDeviationAndKeepsTheSum) {
  constexpr int kSize = 64;
  const auto pilots = noisy_pilots(kSize, [](int x, int) { return x < 32 ? 0.1f : 0.3f; });
  std::vector<uint8_t> seen(kSize * kSize, 1);
  for (int i = 0; i < 10 * kSize; ++i) seen[static_cast<size_t>(i)] = 0;
  const std::vector<uint32_t> budget = adaptive_budget(pilots, seen, kSize, 100);
  double left = 0, right = 0, sum = 0;
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const double paths = budget[static_cast<size_t>(y) * kSize + x];
      ASSERT_EQ(paths > 0, y >= 10);
      sum += paths;
      if (x >= 4 && x < 24) left += paths;
      if (x >= 40 && x < 60) right += paths;
    }
  EXPECT_NEAR(sum, 100.0 * kSize * (kSize - 10), 0.01 * sum);
  EXPECT_NEAR(right / left, 3, 0.15);
}

TEST(AdaptiveBudget, NobodyStarves) {
  constexpr int kSize = 32;
  const auto pilots = noisy_pilots(kSize, [](int x, int y) { return x == 16 && y == 16 ? 50.0f : 0.0f; });
  const std::vector<uint32_t> budget =
      adaptive_budget(pilots, std::vector<uint8_t>(kSize * kSize, 1), kSize, 64);
  for (const uint32_t paths : budget) ASSERT_GE(paths, 16u);
  const auto silent = noisy_pilots(kSize, [](int, int) { return 0.0f; });
  for (const uint32_t paths : adaptive_budget(silent, std::vector<uint8_t>(kSize * kSize, 1), kSize, 64))
    ASSERT_EQ(paths, 64u);
}

TEST(ContinuedBudget, FollowsTheNoiseAboveWhatIsMade) {
  constexpr int kSize = 64;
  const auto begun = noisy_pilots(
      kSize, [](int x, int) { return 0.02f * std::exp2(static_cast<float>(x) / 16); });  // of 1 to 16
  std::vector<uint8_t> seen(kSize * kSize, 1);
  for (int i = 0; i < 10 * kSize; ++i) seen[static_cast<size_t>(i)] = 0;
  const std::vector<uint32_t> budget = continued_budget(begun, 8, seen, kSize, 64);
  double sum = 0, n = 0, xs = 0, ys = 0, xx = 0, xy = 0;  // of a line through log2(paths) over x
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const uint32_t paths = budget[static_cast<size_t>(y) * kSize + x];
      ASSERT_EQ(paths >= 8, y >= 10);
      sum += paths;
      if (y < 12 || x < 16 || x > 60) continue;  // without the least budgets and the borders
      const double log2 = std::log2(paths);
      n += 1, xs += x, ys += log2, xx += x * x, xy += x * log2;
    }
  EXPECT_NEAR(sum / (64.0 * kSize * (kSize - 10)), 1, 0.01);
  // n in proportion to the variance to 1 / (1 + 1.3), as squared errors of n^-1.3 want it.
  EXPECT_NEAR((n * xy - xs * ys) / (n * xx - xs * xs) * 16, 2 / 2.3, 0.08);
}

/// With few paths a quarter of them is made before, which nobody can go below: the sum may then rise a
/// little.
TEST(ContinuedBudget, KeepsTheSumWithFewPathsToo) {
  constexpr int kSize = 64;
  const std::vector<uint8_t> seen(kSize * kSize, 1);
  for (const float contrast : {0.0f, 2.0f, 8.0f}) {
    const auto begun = noisy_pilots(
        kSize, [&](int x, int) { return 0.02f * std::exp2(contrast * static_cast<float>(x) / kSize); });
    for (const int spp : {16, 20, 31, 33, 100, 1000}) {
      const uint32_t made = spp < 64 ? 4 : spp < 128 ? 8 : 64;
      const std::vector<uint32_t> budget = continued_budget(begun, made, seen, kSize, spp);
      const double sum = std::accumulate(budget.begin(), budget.end(), 0.0);
      EXPECT_NEAR(sum / (1.0 * spp * kSize * kSize), 1, 0.03) << contrast << " " << spp;
    }
  }
}

TEST(ContinuedBudget, NoPixelDecidesItsOwn) {
  constexpr int kSize = 32;
  const auto deviation = [](int x, int y) { return 0.05f * static_cast<float>(1 + (x / 3 + y / 5) % 7); };
  const std::vector<uint8_t> seen(kSize * kSize, 1);
  const auto before = noisy_pilots(kSize, deviation);
  const std::vector<uint32_t> budget = continued_budget(before, 8, seen, kSize, 64);
  for (int of = 0; of < kPixelClasses; ++of) {
    Pilots changed = before;
    Random random(9, 9, 9);
    for (std::vector<SampleLight>& image : changed.images)
      for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x)
          if (pixel_class(x, y) == of) image[0].radiance.pixel(x, y)[1] *= 40 * random.next();
    const std::vector<uint32_t> other = continued_budget(changed, 8, seen, kSize, 64);
    int differ = 0;
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x) {
        const size_t i = static_cast<size_t>(y) * kSize + x;
        if (pixel_class(x, y) == of)
          ASSERT_EQ(other[i], budget[i]);
        else
          differ += other[i] != budget[i];
      }
    EXPECT_GT(differ, 100) << "the neighbours do";
  }
}

struct Fixture {
  Model model;
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const LightSet> lights;
  RenderSettings settings;
  Fixture() {
    // A shiny, wavy ball under a sun: some pixels are many times noisier than others.
    TestMaterial shiny;
    shiny.roughness = 0.25f;
    shiny.specular = 0.6f;
    model = sphere_model(20, 32, constant_set(shiny));
    for (Vec3f& p : model.positions_cm) p = p + 2 * std::sin(0.5f * p.x) * Vec3f{0, 1, 1};
    scene = build_scene(model);
    Environment environment;
    environment.name = "sunny";
    environment.radiance = Image(64, 32, 3);
    Random random(2, 2, 2);
    for (float& v : environment.radiance.values) v = 0.3f * random.next();
    for (int c = 0; c < 3; ++c) environment.radiance.pixel(50, 9)[c] = 300;
    lights = prepare_lights({environment}, {});
    settings.size_px = 32;
    settings.spp = 32;
  }
  std::vector<float> render(uint64_t seed, bool adaptive, RenderStatistics* statistics = nullptr) const {
    RenderSettings s = settings;
    s.seed = seed;
    s.adaptive = adaptive;
    return render_lights({*scene, *lights, fit_camera(model.positions_cm), 0.3}, s, statistics)[0]
        .radiance.values;
  }
};

TEST(AdaptiveBudget, IsUnbiased) {
  const Fixture fixture;
  constexpr int kSeeds = 200;
  double means[2] = {}, squares[2] = {};
  RenderStatistics statistics[2];
  for (int adaptive = 0; adaptive < 2; ++adaptive)
    for (int k = 0; k < kSeeds; ++k) {
      const std::vector<float> image = fixture.render(static_cast<uint64_t>(1 + k + 1000 * adaptive),
                                                      adaptive == 1, &statistics[adaptive]);
      const double mean =
          std::accumulate(image.begin(), image.end(), 0.0) / static_cast<double>(image.size());
      means[adaptive] += mean / kSeeds, squares[adaptive] += mean * mean / kSeeds;
    }
  const double error =
      std::sqrt((squares[0] - means[0] * means[0] + squares[1] - means[1] * means[1]) / kSeeds);
  EXPECT_NEAR(means[1], means[0], 4.5 * error) << "false alarms: 7 in a million";
  EXPECT_LT(error / means[0], 0.002) << "the test can tell a bias of one per cent";
  EXPECT_NEAR(static_cast<double>(statistics[1].paths) / static_cast<double>(statistics[0].paths), 1, 0.02);
}

TEST(Pilots, OfNeighbouringSeedsShareNoImage) {
  const Fixture fixture;
  std::vector<std::vector<float>> images;
  for (const uint64_t seed : {6, 7}) {
    RenderSettings settings = fixture.settings;
    settings.seed = seed;
    const Picture picture({*fixture.scene, *fixture.lights, fit_camera(fixture.model.positions_cm), 0.3},
                          settings);
    RenderStatistics statistics;
    for (const std::vector<SampleLight>& pilot : render_pilots(picture, 4, 1, statistics, nullptr).images)
      images.push_back(pilot[0].radiance.values);
  }
  for (size_t a = 0; a < images.size(); ++a)
    for (size_t b = 0; b < a; ++b) EXPECT_NE(images[a], images[b]) << a << " " << b;
}

TEST(PathRange, ClassesHaveLightCandidatesOfTheirOwn) {
  Fixture fixture;
  fixture.settings.guess_shadows = false;
  const Picture picture({*fixture.scene, *fixture.lights, fit_camera(fixture.model.positions_cm), 0.3},
                        fixture.settings);
  const std::vector<uint32_t> two = picture.even_budget(2);
  RenderStatistics statistics;
  const auto shared = render_round(picture, {3, two}, statistics, nullptr);
  const auto by_class = render_round(picture, {3, two, nullptr, true}, statistics, nullptr);
  int lit[kPixelClasses] = {}, differ[kPixelClasses] = {};
  for (int y = 0; y < fixture.settings.size_px; ++y)
    for (int x = 0; x < fixture.settings.size_px; ++x) {
      const float a = shared[0].radiance.pixel(x, y)[1], b = by_class[0].radiance.pixel(x, y)[1];
      lit[pixel_class(x, y)] += a > 0;
      differ[pixel_class(x, y)] += a != b;
    }
  EXPECT_EQ(differ[0], 0) << "the first class has those that all would share";
  for (int of = 1; of < kPixelClasses; ++of) EXPECT_GT(differ[of], lit[of] / 2) << of;
}

TEST(PathRange, WhatOneClassFindsChangesNoOther) {
  const Fixture fixture;
  const Picture picture({*fixture.scene, *fixture.lights, fit_camera(fixture.model.positions_cm), 0.3},
                        fixture.settings);
  const int size_px = fixture.settings.size_px;
  const std::vector<uint32_t> all = picture.even_budget(8);
  RenderStatistics statistics;
  for (const bool by_class : {true, false}) {
    const auto together = render_round(picture, {3, all, nullptr, by_class}, statistics, nullptr);
    for (int of = 0; of < kPixelClasses; ++of) {
      std::vector<uint32_t> alone = all;
      for (int y = 0; y < size_px; ++y)
        for (int x = 0; x < size_px; ++x)
          if (pixel_class(x, y) != of) alone[static_cast<size_t>(y) * size_px + x] = 0;
      const auto of_class = render_round(picture, {3, alone, nullptr, by_class}, statistics, nullptr);
      int differ = 0;
      for (int y = 0; y < size_px; ++y)
        for (int x = 0; x < size_px; ++x)
          if (pixel_class(x, y) == of)
            differ += together[0].radiance.pixel(x, y)[1] != of_class[0].radiance.pixel(x, y)[1];
      if (by_class)
        EXPECT_EQ(differ, 0) << of;
      else
        EXPECT_GT(differ, 0) << "pixels guess shadows for their neighbours";
    }
  }
}

TEST(AdaptiveBudget, SameBitsForAnyThreadCount) {
  const Fixture fixture;
  const std::vector<float> all = fixture.render(7, true);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(fixture.render(7, true), all);
}

}  // namespace
}  // namespace ohb
