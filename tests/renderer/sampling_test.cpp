// The stratified numbers of a path.
#include "dataset/model/sampling.h"

#include <gtest/gtest.h>

#include <set>
#include <vector>

#include "renderer/eight.h"

namespace ohb {
using namespace renderer;
namespace {

// Sobol's second dimension by its direction numbers (primitive polynomial x + 1, m1 = 1).
uint32_t second_dimension_by_direction_numbers(uint32_t index) {
  uint32_t result = 0;
  for (uint32_t v = 1u << 31; index != 0; index >>= 1, v ^= v >> 1)
    if (index & 1) result ^= v;
  return result;
}

TEST(Sobol, SecondDimensionEqualsItsDirectionNumbers) {
  Random random(1, 2, 3);
  for (uint32_t i = 0; i < 5000; ++i) {
    const uint32_t index = i < 1000 ? i : random.next_bits();
    uint32_t x, y;
    sobol_pair(index, x, y);
    EXPECT_EQ(y, second_dimension_by_direction_numbers(index));
  }
}

TEST(PathSampler, EveryElementaryIntervalHoldsOnePoint) {
  for (const int log2_count : {4, 6, 8})
    for (uint64_t pixel = 0; pixel < 5; ++pixel) {
      const uint32_t count = 1u << log2_count;
      std::vector<std::vector<Vec2f>> pairs(PathSampler::kStratifiedPairs);
      for (uint32_t s = 0; s < count; ++s) {
        PathSampler sampler(42, pixel, s);
        for (auto& pair : pairs) pair.push_back(sampler.next_pair());
      }
      for (const auto& points : pairs)
        for (int columns = 0; columns <= log2_count; ++columns) {
          std::set<std::pair<int, int>> cells;
          for (const Vec2f p : points)
            cells.insert({static_cast<int>(p.x * static_cast<float>(1 << columns)),
                          static_cast<int>(p.y * static_cast<float>(1 << (log2_count - columns)))});
          EXPECT_EQ(cells.size(), count);
        }
    }
}

TEST(PathSampler, PixelsSeedsAndPairsAreUncorrelated) {
  // Correlation of 20000 numbers between neighbours: 5 standard deviations are 0.035.
  constexpr int kCount = 20000;
  for (int kind = 0; kind < 3; ++kind) {
    double xy = 0, mean_a = 0, mean_b = 0;
    for (uint64_t i = 0; i < kCount; ++i) {
      PathSampler a(7, i, 3), b(kind == 0 ? 8 : 7, kind == 1 ? i + 1 : i, 3);
      double u = a.next_pair().x, v = b.next_pair().x;
      if (kind == 2) v = b.next_pair().x;
      xy += (u - 0.5) * (v - 0.5) * 12;
      mean_a += u - 0.5;
      mean_b += v - 0.5;
    }
    EXPECT_LT(std::abs(xy / kCount), 0.035) << kind;
    EXPECT_LT(std::abs(mean_a / kCount), 5 * 0.2887 / std::sqrt(kCount)) << kind;
    EXPECT_LT(std::abs(mean_b / kCount), 5 * 0.2887 / std::sqrt(kCount)) << kind;
  }
}

TEST(TurnsOf, EqualsTheArcTangent) {
  Random random(3, 0, 0);
  double worst = 0;
  for (int i = 0; i < 200000; ++i) {
    const float scale = std::exp2(80 * random.next() - 40);
    const float x = scale * (2 * random.next() - 1), y = (i % 2 ? scale : 1.0f) * (2 * random.next() - 1);
    worst = std::max(worst, std::fabs(turns_of(y, x) - std::atan2(double{y}, double{x}) / (2 * M_PI)));
  }
  EXPECT_LT(worst, 1e-7);
  EXPECT_EQ(turns_of(0, 0), 0);
  EXPECT_EQ(turns_of(0, 1), 0);
  EXPECT_EQ(turns_of(1, 0), 0.25f);
  EXPECT_EQ(turns_of(-1, 0), -0.25f);
  EXPECT_EQ(turns_of(0, -1), 0.5f);
}

// Of eight at once, against double precision; every lane its own number.
TEST(Eight, ExponentialLogarithmAndSinesAreWithinRounding) {
  Random random(4, 0, 0);
  double exponential = 0, logarithm = 0, sines = 0;
  for (int i = 0; i < 50000; ++i) {
    alignas(32) float x[8], positive[8], turns[8];
    for (int k = 0; k < 8; ++k) {
      x[k] = 174 * random.next() - 87;
      positive[k] = i % 2 ? 1 - random.next() : std::exp2(120 * random.next() - 60);
      turns[k] = random.next();
    }
    const Float8 e = exp_of(Float8(x, stdx::vector_aligned)),
                 l = log_of(Float8(positive, stdx::vector_aligned));
    Float8 sine, cosine;
    sine_cosine_of_turns(Float8(turns, stdx::vector_aligned), sine, cosine);
    for (int k = 0; k < 8; ++k) {
      exponential = std::max(exponential, std::fabs(e[k] / std::exp(double{x[k]}) - 1));
      const double exact = std::log(double{positive[k]});
      logarithm = std::max(logarithm, std::fabs(l[k] - exact) / std::max(std::fabs(exact), 1e-3));
      sines = std::max({sines, std::fabs(sine[k] - std::sin(2 * M_PI * turns[k])),
                        std::fabs(cosine[k] - std::cos(2 * M_PI * turns[k]))});
    }
  }
  EXPECT_LT(exponential, 2e-7);
  EXPECT_LT(logarithm, 2e-7);
  EXPECT_LT(sines, 5e-7);
  EXPECT_EQ(log_of(Float8(1.0f))[0], 0.0f);
  EXPECT_EQ(exp_of(Float8(0.0f))[3], 1.0f);
  EXPECT_LT(exp_of(Float8(-1000.0f))[5], 2e-38f);
  EXPECT_GT(exp_of(Float8(1000.0f))[7], 1e38f);
}

}  // namespace
}  // namespace ohb
