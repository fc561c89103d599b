#include "bake/uv_charts.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <unordered_map>

namespace ohb::bake {
namespace {

uint64_t bits_of(Vec2f uv) {
  uint32_t x, y;
  uv = uv + Vec2f{0, 0};  // -0 becomes 0
  std::memcpy(&x, &uv.x, 4);
  std::memcpy(&y, &uv.y, 4);
  return uint64_t{x} << 32 | y;
}

uint32_t root_of(std::vector<uint32_t>& parent, uint32_t i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

/// The smallest triangle of each one's group.
std::vector<uint32_t> group_by_uv(const std::vector<surface::UvTriangle>& uvs) {
  std::vector<uint32_t> parent(uvs.size());
  std::iota(parent.begin(), parent.end(), 0u);
  std::unordered_map<uint64_t, uint32_t> first_at;
  first_at.reserve(uvs.size());
  for (uint32_t t = 0; t < uvs.size(); ++t)
    for (const Vec2f& uv : uvs[t].uv) {
      const uint32_t a = root_of(parent, first_at.emplace(bits_of(uv), t).first->second);
      const uint32_t b = root_of(parent, t);
      parent[std::max(a, b)] = std::min(a, b);
    }
  for (uint32_t t = 0; t < parent.size(); ++t) parent[t] = root_of(parent, t);
  return parent;
}

struct Box {
  Vec2f uv_low{1e30f, 1e30f}, uv_high{-1e30f, -1e30f};
  Vec3f low{1e30f, 1e30f, 1e30f}, high{-1e30f, -1e30f, -1e30f};
  void add(Vec2f uv, Vec3f p) {
    uv_low = {std::min(uv_low.x, uv.x), std::min(uv_low.y, uv.y)};
    uv_high = {std::max(uv_high.x, uv.x), std::max(uv_high.y, uv.y)};
    for (int i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], p[i]);
      high[i] = std::max(high[i], p[i]);
    }
  }
};

/// Whether a texel inside the triangle shows another one that lies over it.
bool is_under_another(uint32_t t, const surface::UvTriangle& uv, const surface::TexelCoverage& coverage) {
  const surface::TexelTriangle in_texels = surface::to_texel_space(uv, coverage.width_px, coverage.height_px);
  constexpr double kInside = 0.8;
  const double weights[4][3] = {{1.0 / 3, 1.0 / 3, 1.0 / 3},
                                {kInside / 2, kInside / 2, 1 - kInside},
                                {kInside / 2, 1 - kInside, kInside / 2},
                                {1 - kInside, kInside / 2, kInside / 2}};
  const auto wrap = [](double i, int n) {
    const int rest = static_cast<int>(std::floor(i)) % n;
    return rest < 0 ? rest + n : rest;
  };
  for (const auto& w : weights) {
    double x = 0, y = 0;
    for (int c = 0; c < 3; ++c) {
      x += w[c] * in_texels.corner[c].x;
      y += w[c] * in_texels.corner[c].y;
    }
    const int column = wrap(x, coverage.width_px);
    const int row = coverage.height_px - 1 - wrap(y, coverage.height_px);
    const size_t texel = static_cast<size_t>(row) * coverage.width_px + column;
    if ((coverage.flags[texel] & surface::TexelCoverage::kOverlapping) && coverage.owner[texel] != t)
      return true;
  }
  return false;
}

}  // namespace

UvCharts find_charts(const Model& model, const std::vector<uint32_t>& triangles,
                     const std::vector<surface::UvTriangle>& uvs, int width_px, int height_px) {
  constexpr uint32_t kNone = 0xffffffffu;
  UvCharts charts;
  charts.chart_of = group_by_uv(uvs);
  std::vector<uint32_t> number(uvs.size(), kNone);
  std::vector<Box> boxes;
  for (size_t t = 0; t < uvs.size(); ++t) {
    uint32_t& chart = number[charts.chart_of[t]];
    if (chart == kNone) {
      chart = static_cast<uint32_t>(boxes.size());
      boxes.emplace_back();
    }
    charts.chart_of[t] = chart;
    for (int c = 0; c < 3; ++c)
      boxes[chart].add(uvs[t].uv[c], model.positions_cm[model.triangles[triangles[t]].position[c]]);
  }
  for (const Box& box : boxes)
    charts.charts.push_back({(double(box.uv_high.x) - box.uv_low.x) * width_px,
                             (double(box.uv_high.y) - box.uv_low.y) * height_px, length(box.high - box.low)});
  return charts;
}

std::vector<uint32_t> triangles_with_seams(const UvCharts& charts, const std::vector<uint32_t>& triangles,
                                           const std::vector<surface::UvTriangle>& uvs,
                                           const surface::TexelCoverage& coverage) {
  constexpr double kLeast_texels = 2;
  std::vector<uint32_t> kept;
  for (uint32_t t = 0; t < triangles.size(); ++t) {
    const UvChart& chart = charts.charts[charts.chart_of[t]];
    if (chart.width_texels < kLeast_texels || chart.height_texels < kLeast_texels) continue;
    if (surface::to_texel_space(uvs[t], coverage.width_px, coverage.height_px).is_degenerate) continue;
    if (coverage.overlapping_texels > 0 && is_under_another(t, uvs[t], coverage)) continue;
    kept.push_back(triangles[t]);
  }
  return kept;
}

}  // namespace ohb::bake
