#include "dataset/surface/texel_coverage.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <array>
#include <random>
#include <set>

#include "bake/canonical_mesh.h"
#include "tests/support/shared_data.h"

namespace ohb {
using namespace bake;
using namespace surface;
namespace {

/// UVs are multiples of 2^-22, which a float holds exactly below 4. Times the size of the map they are texels
/// in the same fixed point, so that the oracle's integers are exact and its products fit 64 bits.
constexpr int64_t kOne = 1 << 22;

struct IntTriangle {
  std::array<std::array<int64_t, 2>, 3> corner;  // y up
};

UvTriangle to_uv(const IntTriangle& t) {
  UvTriangle uv{};
  for (int c = 0; c < 3; ++c)
    uv.uv[c] = {static_cast<float>(t.corner[c][0]) / kOne, static_cast<float>(t.corner[c][1]) / kOne};
  return uv;
}

/// Whether the triangle holds the point (x, y) moved by an infinitesimal step right and a far smaller one
/// down: another way to state the top-left rule.
bool oracle_holds(IntTriangle t, int64_t x, int64_t y) {
  const auto& c = t.corner;
  const int64_t area = (c[1][0] - c[0][0]) * (c[2][1] - c[0][1]) - (c[1][1] - c[0][1]) * (c[2][0] - c[0][0]);
  if (area == 0) return false;
  for (int i = 0; i < 3; ++i) {
    const auto &a = c[i], &b = c[(i + 1) % 3];
    const int64_t dx = b[0] - a[0], dy = b[1] - a[1];
    int64_t side = dx * (y - a[1]) - dy * (x - a[0]);
    if (side == 0) side = -dy;  // the step to the right
    if (side == 0) side = -dx;  // the step down
    if ((side > 0) != (area > 0)) return false;
  }
  return true;
}

/// Owners by centre, brute force over all triangles and repetitions; `claims` counts triangles a texel.
std::vector<uint32_t> oracle_owners(const std::vector<IntTriangle>& triangles, int width, int height,
                                    std::vector<int>& claims) {
  std::vector<uint32_t> owner(static_cast<size_t>(width) * height, TexelCoverage::kNone);
  claims.assign(owner.size(), 0);
  for (int row = 0; row < height; ++row)
    for (int x = 0; x < width; ++x)
      for (size_t t = 0; t < triangles.size(); ++t)
        for (int j = -2; j <= 2; ++j)
          for (int i = -2; i <= 2; ++i) {
            IntTriangle in_texels = triangles[t];
            for (auto& corner : in_texels.corner) corner = {corner[0] * width, corner[1] * height};
            const int64_t cx = kOne * (x + i * width) + kOne / 2;
            const int64_t cy = kOne * (height - 1 - row + j * height) + kOne / 2;
            if (!oracle_holds(in_texels, cx, cy)) continue;
            const size_t texel = static_cast<size_t>(row) * width + x;
            if (claims[texel]++ == 0) owner[texel] = static_cast<uint32_t>(t);
          }
  return owner;
}

void expect_as_oracle(const std::vector<IntTriangle>& triangles, int width, int height) {
  std::vector<UvTriangle> uvs;
  for (const IntTriangle& t : triangles) uvs.push_back(to_uv(t));
  const TexelCoverage coverage = cover_texels(uvs, width, height);
  std::vector<int> claims;
  const std::vector<uint32_t> owner = oracle_owners(triangles, width, height, claims);
  uint64_t centres = 0, overlapping = 0, owned = 0;
  for (size_t i = 0; i < owner.size(); ++i) {
    if (claims[i] > 0) {
      EXPECT_EQ(coverage.owner[i], owner[i]) << "texel " << i;
    }
    centres += claims[i] > 0;
    overlapping += claims[i] > 1;
    owned += coverage.owner[i] != TexelCoverage::kNone;
  }
  EXPECT_EQ(coverage.centre_texels, centres);
  EXPECT_EQ(coverage.overlapping_texels, overlapping);
  EXPECT_EQ(coverage.centre_texels + coverage.footprint_texels, owned);
}

/// Corners on multiples of `step` (in units of 1 / kOne) between low and high (in UV units).
IntTriangle random_triangle(std::mt19937& random, int64_t step, double low, double high) {
  std::uniform_int_distribution<int64_t> place(static_cast<int64_t>(low * kOne / step),
                                               static_cast<int64_t>(high * kOne / step));
  IntTriangle t{};
  for (auto& corner : t.corner) corner = {step * place(random), step * place(random)};
  return t;
}

TEST(TexelCoverage, CentresAreAsInExactArithmetic) {
  std::mt19937 random(1);
  for (int round = 0; round < 60; ++round) {
    // Every second round corners lie on halves of a texel, so that edges run through many centres.
    const int64_t step = round % 2 ? kOne / 64 : 1;
    std::vector<IntTriangle> triangles;
    for (int i = 0; i < 12; ++i) triangles.push_back(random_triangle(random, step, 0, 1));
    if (round % 2)
      expect_as_oracle(triangles, 32, 16);
    else
      expect_as_oracle(triangles, 24, 17);
  }
}

TEST(TexelCoverage, SliversAreAsInExactArithmetic) {
  std::mt19937 random(2);
  std::uniform_int_distribution<int64_t> near(-2, 2);
  for (int round = 0; round < 60; ++round) {
    const int64_t step = round % 2 ? kOne / 64 : 1;
    std::vector<IntTriangle> triangles;
    for (int i = 0; i < 12; ++i) {
      IntTriangle t = random_triangle(random, step, 0, 1);
      t.corner[2] = {t.corner[1][0] + step * near(random), t.corner[1][1] + step * near(random)};
      triangles.push_back(t);
    }
    expect_as_oracle(triangles, 32, 17);
  }
}

TEST(TexelCoverage, UvsOutsideTheMapRepeatIt) {
  std::mt19937 random(3);
  for (int round = 0; round < 30; ++round) {
    std::vector<IntTriangle> triangles;
    for (int i = 0; i < 6; ++i)
      triangles.push_back(random_triangle(random, round % 2 ? kOne / 32 : 1, -1.2, 1.9));
    expect_as_oracle(triangles, 16, 11);
  }
}

/// A jittered grid of triangles that tiles [0,1] x [0,1]; corners on the grid or anywhere.
std::vector<UvTriangle> jittered_grid(int cells, float jitter, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> step(-jitter, jitter);
  const auto corner = [&](int i, int j) {
    const bool is_border = i == 0 || j == 0 || i == cells || j == cells;
    const float x = static_cast<float>(i) / static_cast<float>(cells);
    const float y = static_cast<float>(j) / static_cast<float>(cells);
    return is_border ? Vec2f{x, y} : Vec2f{x + step(random) / cells, y + step(random) / cells};
  };
  std::vector<Vec2f> corners;
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i) corners.push_back(corner(i, j));
  std::vector<UvTriangle> triangles;
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const int a = j * (cells + 1) + i, b = a + 1, c = a + cells + 1, d = c + 1;
      triangles.push_back({{corners[a], corners[b], corners[d]}});
      triangles.push_back({{corners[d], corners[c], corners[a]}});
    }
  return triangles;
}

TEST(TexelCoverage, NeighboursNeitherClaimATexelTwiceNorLeaveAGap) {
  for (uint32_t seed = 0; seed < 8; ++seed)
    for (int cells : {1, 3, 16, 61})
      for (int size : {16, 61, 128, 333}) {
        const TexelCoverage coverage = cover_texels(jittered_grid(cells, 0.3f, seed), size, size);
        EXPECT_EQ(coverage.centre_texels, static_cast<uint64_t>(size) * size) << cells << " in " << size;
        EXPECT_EQ(coverage.overlapping_texels, 0u) << cells << " in " << size;
        EXPECT_EQ(coverage.footprint_texels, 0u);
      }
}

/// Draws points inside the triangles and checks that the four texels of a bilinear lookup are all defined.
void expect_defined_lookups(const std::vector<UvTriangle>& triangles, const TexelCoverage& coverage,
                            int points, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  std::uniform_int_distribution<size_t> any(0, triangles.size() - 1);
  int undefined = 0;
  for (int k = 0; k < points; ++k) {
    const UvTriangle& t = triangles[any(random)];
    double a = unit(random), b = unit(random);
    if (a + b > 1) a = 1 - a, b = 1 - b;
    if (k % 3 == 0) b = 0;          // on an edge
    if (k % 31 == 0) a = 1, b = 0;  // on a corner
    const double u = t.uv[0].x + a * (double(t.uv[1].x) - t.uv[0].x) + b * (double(t.uv[2].x) - t.uv[0].x);
    const double v = t.uv[0].y + a * (double(t.uv[1].y) - t.uv[0].y) + b * (double(t.uv[2].y) - t.uv[0].y);
    const double x = u * coverage.width_px - 0.5, y = (1 - v) * coverage.height_px - 0.5;
    for (int j = 0; j < 2; ++j)
      for (int i = 0; i < 2; ++i) {
        const auto wrap = [](double value, int size) {
          return static_cast<int>(std::floor(value) - std::floor(std::floor(value) / size) * size);
        };
        if ((i && x == std::floor(x)) || (j && y == std::floor(y))) continue;  // weight 0
        const int column = wrap(x + i, coverage.width_px), row = wrap(y + j, coverage.height_px);
        undefined += coverage.owner_of(column, row) == TexelCoverage::kNone;
      }
  }
  EXPECT_EQ(undefined, 0);
}

TEST(TexelCoverage, LookupsInsideTrianglesFindDefinedTexels) {
  std::mt19937 random(4);
  std::uniform_real_distribution<float> place(-0.3f, 1.3f), small(-0.01f, 0.01f);
  for (int size : {8, 32, 100}) {
    std::vector<UvTriangle> triangles;
    for (int i = 0; i < 40; ++i) {
      const Vec2f a{place(random), place(random)};
      const bool is_small = i % 4 != 0;
      const auto other = [&] {
        return is_small ? Vec2f{a.x + small(random), a.y + small(random)}
                        : Vec2f{place(random), place(random)};
      };
      triangles.push_back({{a, other(), other()}});
      if (i % 5 == 0) triangles.back().uv[2] = triangles.back().uv[1];  // a line
    }
    expect_defined_lookups(triangles, cover_texels(triangles, size, size), 40000, 5);
  }
}

TEST(TexelCoverage, LookupsOnRealMeshesFindDefinedTexels) {
  OHB_SHARED_DATA_OR_SKIP(humans, "humans");
  for (const char* file : {"f33_leatherjacket/f33_leatherjacket_scan.obj", "m48_suit/m48_suit_scan.obj"}) {
    const Scan scan = read_scan(humans / file);
    std::vector<UvTriangle> triangles;
    for (const ScanTriangle& t : triangulate(scan)) {
      UvTriangle uv{};
      for (int c = 0; c < 3; ++c) uv.uv[c] = scan.uvs[scan.corners[t.corner[c]].uv];
      triangles.push_back(uv);
    }
    for (int size : {256, 777})
      expect_defined_lookups(triangles, cover_texels(triangles, size, size), 200000, 6);
  }
}

TEST(TexelCoverage, TriangleSmallerThanATexelOwnsOne) {
  // Far from any centre, in the middle of nothing.
  const std::vector<UvTriangle> alone = {{{{0.50f, 0.50f}, {0.501f, 0.50f}, {0.50f, 0.501f}}}};
  const TexelCoverage coverage = cover_texels(alone, 16, 16);
  EXPECT_EQ(coverage.centre_texels, 0u);
  EXPECT_GE(coverage.footprint_texels, 4u);
  EXPECT_TRUE(coverage.triangles_without_texel.empty());
}

TEST(TexelCoverage, LinesAndPointsInUvOwnTexelsToo) {
  const std::vector<UvTriangle> degenerate = {{{{0.1f, 0.1f}, {0.4f, 0.1f}, {0.2f, 0.1f}}},
                                              {{{0.8f, 0.8f}, {0.8f, 0.8f}, {0.8f, 0.8f}}}};
  const TexelCoverage coverage = cover_texels(degenerate, 16, 16);
  EXPECT_EQ(coverage.centre_texels, 0u);
  EXPECT_TRUE(coverage.triangles_without_texel.empty());
}

TEST(TexelCoverage, HiddenAndTexelLessTrianglesAreListed) {
  const UvTriangle low{{{0, 0}, {1, 0}, {1, 1}}}, high{{{0, 0}, {1, 1}, {0, 1}}};
  const UvTriangle hidden{{{0.5f, 0.1f}, {0.9f, 0.1f}, {0.9f, 0.5f}}};
  const UvTriangle tiny{{{0.5f, 0.25f}, {0.501f, 0.25f}, {0.5f, 0.251f}}};
  const TexelCoverage coverage = cover_texels({low, high, hidden, tiny}, 16, 16);
  EXPECT_EQ(coverage.triangles_without_texel, (std::vector<uint32_t>{2, 3}));
  EXPECT_EQ(coverage.hidden_triangles, std::vector<uint32_t>{2});
  EXPECT_GT(coverage.overlapping_texels, 10u);
}

TEST(TexelCoverage, BorderTexelsShowTheNearestTriangle) {
  // Two charts with a gap of three texels; the texels of the gap belong to the closer side.
  const std::vector<UvTriangle> charts = {{{{0.1f, 0.1f}, {0.40f, 0.1f}, {0.40f, 0.9f}}},
                                          {{{0.59f, 0.1f}, {0.9f, 0.1f}, {0.59f, 0.9f}}}};
  const TexelCoverage coverage = cover_texels(charts, 16, 16);  // edges at x = 6.4 and 9.44
  EXPECT_EQ(coverage.owner_of(6, 10), 0u);
  EXPECT_EQ(coverage.owner_of(9, 10), 1u);
  EXPECT_EQ(coverage.owner_of(8, 10), 1u);
  EXPECT_EQ(coverage.owner_of(7, 10), TexelCoverage::kNone);
}

TEST(TexelCoverage, SameForAnyNumberOfThreads) {
  std::vector<UvTriangle> triangles = jittered_grid(40, 3.0f, 9);  // folded: many overlaps
  std::vector<TexelCoverage> results;
  for (size_t threads : {1, 2, 8}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    results.push_back(cover_texels(triangles, 500, 300));
  }
  for (const TexelCoverage& result : results) {
    EXPECT_EQ(result.owner, results[0].owner);
    EXPECT_EQ(result.overlapping_texels, results[0].overlapping_texels);
  }
}

TEST(TexelCoverage, RefusesUvsItCannotResolve) {
  EXPECT_THROW(cover_texels({{{{0, 0}, {9, 0}, {0, 1}}}}, 8, 8), std::logic_error);
  EXPECT_THROW(cover_texels({{{{2000, 0}, {2000, 1}, {2001, 1}}}}, 8, 8), std::logic_error);
  EXPECT_THROW(cover_texels({{{{NAN, 0}, {0, 1}, {1, 1}}}}, 8, 8), std::logic_error);
}

TEST(UvGeometry, DifferenceOfProductsHasTheExactSign) {
  // (1 + e)(1 - e) - 1 x 1 = -e^2, which plain double arithmetic rounds to 0.
  const double e = std::ldexp(1, -40);
  EXPECT_LT(difference_of_products(1 + e, 1 - e, 1, 1), 0);
  EXPECT_GT(difference_of_products(1, 1, 1 + e, 1 - e), 0);
  EXPECT_EQ(difference_of_products(3, 5, 15, 1), 0);
}

TEST(UvGeometry, NearestPointIsNoFartherThanAnySampledPoint) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-5, 5);
  for (int round = 0; round < 300; ++round) {
    TexelPoint c[3];
    for (TexelPoint& p : c) p = {place(random), place(random)};
    if (round % 10 == 0) c[2] = c[1];
    const TexelTriangle triangle(c[0], c[1], c[2]);
    const TexelPoint p{place(random), place(random)};
    const NearestPoint nearest = nearest_point(triangle, p);
    double sum = 0, x = -p.x, y = -p.y;
    for (int i = 0; i < 3; ++i) {
      EXPECT_GE(nearest.weights[i], 0);
      sum += nearest.weights[i];
      x += nearest.weights[i] * c[i].x;
      y += nearest.weights[i] * c[i].y;
    }
    EXPECT_NEAR(sum, 1, 1e-12);
    EXPECT_NEAR(x * x + y * y, nearest.squared_distance, 1e-9);
    for (int a = 0; a <= 40; ++a)
      for (int b = 0; a + b <= 40; ++b) {
        const double wa = a / 40.0, wb = b / 40.0, wc = 1 - wa - wb;
        const double dx = wa * c[0].x + wb * c[1].x + wc * c[2].x - p.x;
        const double dy = wa * c[0].y + wb * c[1].y + wc * c[2].y - p.y;
        EXPECT_GE(dx * dx + dy * dy, nearest.squared_distance - 1e-9);
      }
  }
}

}  // namespace
}  // namespace ohb
