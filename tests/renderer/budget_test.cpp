// Paths where the noise is: as many as promised, in the right places, and without bias.
#include "renderer/budget.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <numeric>

#include "renderer/render.h"
#include "renderer/sampling.h"
#include "tests/support/test_models.h"

namespace ohb {
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

TEST(PowersOfTwo, KeepTheSumAndStayWithinAFactor) {
  Random random(5, 0, 0);
  for (const double spread : {0.0, 0.3, 3.0}) {
    std::vector<uint32_t> budget(5000, 0);
    uint64_t wanted = 0, got = 0;
    for (size_t i = 0; i < budget.size(); i += 2)
      wanted += budget[i] = static_cast<uint32_t>(56 * std::exp2(spread * (random.next() - 0.5)));
    const std::vector<uint32_t> rounded = powers_of_two(budget);
    for (size_t i = 0; i < budget.size(); ++i) {
      got += rounded[i];
      ASSERT_EQ(rounded[i] & (rounded[i] - 1), 0u) << "also where nothing is asked for";
      ASSERT_EQ(rounded[i] > 0, budget[i] > 0);
      if (budget[i] > 0) {
        ASSERT_NEAR(std::log2(rounded[i]), std::log2(budget[i]), 1.1);
      }
    }
    EXPECT_LE(got, wanted);
    EXPECT_GT(static_cast<double>(got), 0.98 * static_cast<double>(wanted)) << spread;
  }
  EXPECT_EQ(powers_of_two({1, 0, 1}), (std::vector<uint32_t>{1, 0, 1}));
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
    return render_lights(*scene, *lights, fit_camera(model.positions_cm), 0.3, s, statistics)[0]
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

TEST(AdaptiveBudget, SameBitsForAnyThreadCount) {
  const Fixture fixture;
  const std::vector<float> all = fixture.render(7, true);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(fixture.render(7, true), all);
}

}  // namespace
}  // namespace ohb
