// Both sides of seams agree at every point: the places that stand for all points, the linear system against a
// dense solve, and what comes out for maps that could hardly be worse.
#include "bake/seam_agree.h"

#include <Imath/half.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <random>

#include "bake/seam_places.h"
#include "bake/seam_system.h"
#include "dataset/model/colour.h"
#include "dataset/surface/picture.h"
#include "tests/bake/two_charts.h"

namespace ohb {
using namespace bake;
using namespace surface;
namespace {

/// A bilinear lookup in double precision that shares no code with the bake's.
std::array<double, 3> lookup(const Image& map, Vec2f from, Vec2f to, double along) {
  const double x = (from.x + along * (double(to.x) - from.x)) * map.width_px - 0.5;
  const double y = (1 - from.y - along * (double(to.y) - from.y)) * map.height_px - 0.5;
  const int column = static_cast<int>(std::floor(x)), row = static_cast<int>(std::floor(y));
  std::array<double, 3> value{};
  for (int dy = 0; dy < 2; ++dy)
    for (int dx = 0; dx < 2; ++dx) {
      const double weight = (1 - std::fabs(x - (column + dx))) * (1 - std::fabs(y - (row + dy)));
      const float* const texel =
          map.pixel((column + dx + map.width_px) % map.width_px, (row + dy + map.height_px) % map.height_px);
      for (int c = 0; c < 3; ++c) value[c] += weight * texel[c];
    }
  return value;
}

/// Of a direction in the frame of a side, which is interpolated between its ends.
std::array<double, 3> in_model(const SeamSide& side, double along, const std::array<double, 3>& v) {
  double t[3], n[3];
  for (int c = 0; c < 3; ++c) {
    t[c] = side.tangent[0][c] + along * (double(side.tangent[1][c]) - side.tangent[0][c]);
    n[c] = side.normal[0][c] + along * (double(side.normal[1][c]) - side.normal[0][c]);
  }
  std::array<double, 3> out;
  for (int c = 0; c < 3; ++c) {
    const int d = (c + 1) % 3, e = (c + 2) % 3;
    out[c] = v[0] * t[c] + v[1] * side.sign * (n[d] * t[e] - n[e] * t[d]) + v[2] * n[c];
  }
  return out;
}

double dot3(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// The largest over 401 points of each seam, both ends among them: 1/255s, or degrees.
double worst_difference(const Image& map, const std::vector<Seam>& seams, MapValues values) {
  constexpr int kSteps = 400;
  double worst = 0;
  for (const Seam& seam : seams)
    for (int i = 0; i <= kSteps; ++i) {
      const double along = double(i) / kSteps;
      std::array<double, 3> v[2];
      for (int k = 0; k < 2; ++k) {
        const SeamSide& side = seam.side[k];
        v[k] = lookup(map, side.uv[0], side.uv[1], along);
        if (values == MapValues::kNormals) v[k] = in_model(side, along, v[k]);
        if (values == MapValues::kLinearColour)
          for (double& c : v[k]) c = linear_to_srgb(static_cast<float>(c));
      }
      if (values == MapValues::kNormals) {
        const double cosine = dot3(v[0], v[1]) / std::sqrt(dot3(v[0], v[0]) * dot3(v[1], v[1]));
        worst = std::max(worst, std::acos(std::min(1.0, cosine)) * 57.29577951308232);
      } else {
        for (int c = 0; c < 3; ++c) worst = std::max(worst, 255 * std::fabs(v[0][c] - v[1][c]));
      }
    }
  return worst;
}

/// As EXR files hold it.
Image in_halves(Image map) {
  for (float& value : map.values) value = Imath::half(value);
  return map;
}

double most_changed_inside(const TwoCharts& charts, const Image& before, const Image& after) {
  double most = 0;
  for (size_t i = 0; i < before.values.size(); ++i)
    if (charts.is_inside[i / 3]) most = std::max<double>(most, std::fabs(before.values[i] - after.values[i]));
  return most;
}

TEST(SeamPlaces, BoundEveryPointBetween) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> any(-1, 1);
  for (float degrees : {0.0f, 11.0f, 45.0f}) {
    const TwoCharts charts(64, degrees, degrees > 20);
    Image map(64, 64, 3);
    for (float& value : map.values) value = any(random);
    const SeamPlaces places(charts.seams, 64, 64);
    std::vector<double> at_places(charts.seams.size());
    for (const SeamPlace& place : places.places)
      for (int c = 0; c < 3; ++c) {
        double apart = 0;
        for (int k = 0; k < 2; ++k)
          for (int j = 0; j < 4; ++j)
            apart += (k == 0 ? 1 : -1) * double(place.weight[k][j]) *
                     map.values[size_t{places.texels[place.texel[k][j]]} * 3 + c];
        at_places[place.seam] = std::max(at_places[place.seam], std::fabs(apart));
      }
    for (size_t s = 0; s < charts.seams.size(); ++s) {
      const double everywhere = worst_difference(map, {charts.seams[s]}, MapValues::kPlain) / 255;
      EXPECT_LE(everywhere, kQuadraticOvershoot * at_places[s] + 1e-4) << degrees << ' ' << s;
    }
  }
}

/// x of a symmetric system by Gaussian elimination.
std::vector<double> dense_solve(std::vector<std::vector<double>> a, std::vector<double> b) {
  const size_t n = b.size();
  for (size_t p = 0; p < n; ++p)
    for (size_t r = p + 1; r < n; ++r) {
      const double factor = a[r][p] / a[p][p];
      for (size_t c = p; c < n; ++c) a[r][c] -= factor * a[p][c];
      b[r] -= factor * b[p];
    }
  for (size_t p = n; p-- > 0;) {
    for (size_t c = p + 1; c < n; ++c) b[p] -= a[p][c] * b[c];
    b[p] /= a[p][p];
  }
  return b;
}

template <int kFree, int kColumns>
void expect_as_dense() {
  using System = SeamSystem<kFree, kColumns>;
  constexpr uint32_t kUnknowns = 40;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-1, 1);
  std::vector<typename System::Row> rows(90);
  for (typename System::Row& row : rows) {
    for (int k = 0; k < 8; ++k) {
      row.unknown[k] =
          random() % 5 == 0 ? System::kNone : random() % kUnknowns;  // twice the same now and then
      for (double& effect : row.effect[k]) effect = any(random);
    }
    for (double& difference : row.difference) difference = any(random);
    row.weight = std::pow(10, 3 * any(random));
  }
  std::vector<typename System::Texel> texels(kUnknowns);
  for (typename System::Texel& texel : texels) {
    texel.hold = 1.5 + any(random);
    for (double& pull : texel.pull) pull = any(random);
  }
  System system(kUnknowns, rows);
  const auto found = system.solve(rows, texels);
  for (int column = 0; column < kColumns; ++column) {
    constexpr size_t n = size_t{kFree} * kUnknowns;
    std::vector<std::vector<double>> a(n, std::vector<double>(n));
    std::vector<double> b(n);
    for (size_t i = 0; i < n; ++i) {
      a[i][i] = texels[i / kFree].hold;
      b[i] = texels[i / kFree].pull[i % kFree * kColumns + column];
    }
    for (const typename System::Row& row : rows)
      for (int d = 0; d < kFree; ++d) {
        std::vector<double> effect(n);
        for (int k = 0; k < 8; ++k)
          if (row.unknown[k] != System::kNone)
            for (int f = 0; f < kFree; ++f)
              effect[kFree * row.unknown[k] + f] += row.effect[k][d * kFree + f];
        for (size_t i = 0; i < n; ++i) {
          for (size_t j = 0; j < n; ++j) a[i][j] += row.weight * effect[i] * effect[j];
          b[i] -= row.weight * effect[i] * row.difference[d * kColumns + column];
        }
      }
    const std::vector<double> wanted = dense_solve(a, b);
    for (size_t i = 0; i < n; ++i)
      EXPECT_NEAR(found[i / kFree][i % kFree * kColumns + column], wanted[i], 1e-9);
  }
}

TEST(SeamSystem, SolvesAsADenseSystem) {
  expect_as_dense<1, 3>();
  expect_as_dense<2, 1>();
}

TEST(SeamAgree, EveryPointOfNoiseAgrees) {
  for (const auto& [degrees, is_mirrored] :
       {std::pair{0.0f, false}, {33.0f, true}, {90.0f, false}, {71.0f, true}})
    for (MapValues values : {MapValues::kLinearColour, MapValues::kPlain}) {
      const TwoCharts charts(128, degrees, is_mirrored);
      std::mt19937 random(4);
      std::uniform_real_distribution<float> any(0, 1);
      Image map(128, 128, 3);
      for (float& value : map.values) value = any(random);
      const Image before = map;
      EXPECT_GT(worst_difference(map, charts.seams, values), 100);
      const LevelMending mending = mend_level(map, charts.seams, charts.is_inside, values);
      EXPECT_EQ(mending.points_beyond, 0u);
      EXPECT_LE(worst_difference(in_halves(map), charts.seams, values), 1) << degrees;
      for (float value : map.values) EXPECT_TRUE(value >= 0 && value <= 1);
      EXPECT_FLOAT_EQ(mending.most_changed, static_cast<float>(most_changed_inside(charts, before, map)));
    }
}

// Blacks, where the sRGB curve is steep, beside whites.
TEST(SeamAgree, EveryPointOfBlackAndWhiteAgrees) {
  const TwoCharts charts(128, 20, false);
  std::mt19937 random(5);
  Image map(128, 128, 3);
  for (float& value : map.values) value = random() % 3 ? 0.0f : 1.0f;
  EXPECT_EQ(mend_level(map, charts.seams, charts.is_inside, MapValues::kLinearColour).points_beyond, 0u);
  EXPECT_LE(worst_difference(in_halves(map), charts.seams, MapValues::kLinearColour), 1);
}

// Directions up to 80 degrees from the surface's, each texel its own: lookups between are short and turn
// fast.
TEST(SeamAgree, EveryDirectionOfNoiseAgrees) {
  for (const auto& [degrees, is_mirrored] :
       {std::pair{0.0f, false}, {33.0f, true}, {90.0f, false}, {71.0f, true}}) {
    const TwoCharts charts(128, degrees, is_mirrored);
    std::mt19937 random(4);
    std::uniform_real_distribution<float> any(0, 1);
    Image map(128, 128, 3);
    for (size_t i = 0; i < map.values.size(); i += 3) {
      const float tilt = 1.4f * any(random), turn = 6.2831853f * any(random);
      map.values[i] = std::sin(tilt) * std::cos(turn);
      map.values[i + 1] = std::sin(tilt) * std::sin(turn);
      map.values[i + 2] = std::cos(tilt);
    }
    EXPECT_GT(worst_difference(map, charts.seams, MapValues::kNormals), 40);
    const LevelMending mending = mend_level(map, charts.seams, charts.is_inside, MapValues::kNormals);
    EXPECT_EQ(mending.points_beyond, 0u);
    EXPECT_LE(worst_difference(in_halves(map), charts.seams, MapValues::kNormals), 1) << degrees;
    for (size_t i = 0; i < map.values.size(); i += 3)
      EXPECT_NEAR(length({map.values[i], map.values[i + 1], map.values[i + 2]}), 1, 1e-5);
  }
}

/// Hildreth's method (1957): the least weighted change with every place within `limit`, one channel; slow.
double least_cost(const SeamPlaces& places, const std::vector<double>& hold, const Image& map, int channel,
                  double limit) {
  std::vector<double> value(places.texels.size()), strength(places.places.size());
  for (size_t t = 0; t < value.size(); ++t) value[t] = map.values[size_t{places.texels[t]} * 3 + channel];
  const std::vector<double> before = value;
  for (int sweep = 0; sweep < 20'000; ++sweep)
    for (size_t p = 0; p < places.places.size(); ++p) {
      const SeamPlace& place = places.places[p];
      double apart = 0, give = 0;
      for (int k = 0; k < 2; ++k)
        for (int j = 0; j < 4; ++j) {
          const double weight = (k == 0 ? 1 : -1) * place.weight[k][j];
          apart += weight * value[place.texel[k][j]];
          give += weight * weight / hold[place.texel[k][j]];
        }
      const double free = strength[p] + apart / give;
      const double wanted = free > limit / give    ? free - limit / give
                            : free < -limit / give ? free + limit / give
                                                   : 0;
      const double step = wanted - strength[p];
      if (step == 0) continue;
      strength[p] = wanted;
      for (int k = 0; k < 2; ++k)
        for (int j = 0; j < 4; ++j)
          value[place.texel[k][j]] -= step * (k == 0 ? 1 : -1) * place.weight[k][j] / hold[place.texel[k][j]];
    }
  double cost = 0;
  for (size_t t = 0; t < value.size(); ++t) cost += hold[t] * (value[t] - before[t]) * (value[t] - before[t]);
  return cost;
}

TEST(SeamAgree, ChangesLittleMoreThanItMust) {
  const TwoCharts charts(64, 33, true);
  std::mt19937 random(4);
  std::uniform_real_distribution<float> any(-0.05f, 0.05f);
  const Image before = charts.filled(charts.map_of([&](Vec3f p, Vec3f t, Vec3f n, float s) {
    return smooth_colour(p, t, n, s) + Vec3f{any(random), any(random), any(random)};
  }),
                                     false);
  Image map = before;
  EXPECT_EQ(mend_level(map, charts.seams, charts.is_inside, MapValues::kPlain).points_beyond, 0u);
  const SeamPlaces places(charts.seams, 64, 64);
  std::vector<double> hold;
  for (uint32_t texel : places.texels) hold.push_back(charts.is_inside[texel] ? 10 : 1);
  double cost = 0, least = 0;
  for (int c = 0; c < 3; ++c) {
    least += least_cost(places, hold, before, c, 1.0 / 255);
    for (size_t t = 0; t < places.texels.size(); ++t) {
      const double change =
          map.values[size_t{places.texels[t]} * 3 + c] - before.values[size_t{places.texels[t]} * 3 + c];
      cost += hold[t] * change * change;
    }
  }
  EXPECT_GT(cost, 0.99 * least);
  EXPECT_LT(cost, 1.5 * least);
}

TEST(SeamAgree, TexelsThatNoSeamReadsKeepTheirValues) {
  const TwoCharts charts(128, 33, true);
  std::mt19937 random(4);
  Image map(128, 128, 3);
  for (float& value : map.values) value = static_cast<float>(random() % 256) / 255;
  const Image before = map;
  mend_level(map, charts.seams, charts.is_inside, MapValues::kLinearColour);
  std::vector<uint8_t> is_read(size_t{128} * 128);
  for (uint32_t texel : SeamPlaces(charts.seams, 128, 128).texels) is_read[texel] = 1;
  for (size_t i = 0; i < map.values.size(); ++i)
    EXPECT_TRUE(is_read[i / 3] || map.values[i] == before.values[i]);
}

TEST(SeamAgree, IsTheSameForAnyNumberOfThreads) {
  const TwoCharts charts(128, 33, true);
  for (MapValues values : {MapValues::kLinearColour, MapValues::kNormals}) {
    std::vector<Image> mended;
    for (size_t threads : {1, 2, 5}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      std::mt19937 random(4);
      std::uniform_real_distribution<float> any(0.1f, 1);
      Image map(128, 128, 3);
      for (float& value : map.values) value = any(random);
      if (values == MapValues::kNormals) normalise_pixels(map);
      mend_level(map, charts.seams, charts.is_inside, values);
      mended.push_back(map);
    }
    EXPECT_EQ(mended[1].values, mended[0].values);
    EXPECT_EQ(mended[2].values, mended[0].values);
  }
}

TEST(SeamAgree, LevelsThatAreAllSeamAreOnlySwept) {
  const TwoCharts charts(32, 33, true);
  Image map(32, 32, 3);
  std::mt19937 random(4);
  for (float& value : map.values) value = static_cast<float>(random() % 256) / 255;
  EXPECT_FALSE(mend_level(map, charts.seams, charts.is_inside, MapValues::kPlain).is_swept_only);
  std::vector<uint8_t> is_inside(size_t{32} * 32);
  for (uint32_t texel : SeamPlaces(charts.seams, 32, 32).texels) is_inside[texel] = 1;
  EXPECT_TRUE(mend_level(map, charts.seams, is_inside, MapValues::kPlain).is_swept_only);
}

}  // namespace
}  // namespace ohb
