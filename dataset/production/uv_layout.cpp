#include "dataset/production/uv_layout.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace ohb {
namespace {

/// Texel tests of all faces together; a hostile layout stops there.
constexpr double kMaxTexelTests = 4e9;
/// UV area, of a tile, below which a face has none: far below a texel of an 8K picture.
constexpr double kZeroUvArea = 1e-12;

struct UvTriangle {
  double x[3], y[3];
};

bool has_uvs(const Scan& scan, const ScanTriangle& triangle) {
  return scan.corners[triangle.corner[0]].uv != Corner::kNoUv &&
         scan.corners[triangle.corner[1]].uv != Corner::kNoUv &&
         scan.corners[triangle.corner[2]].uv != Corner::kNoUv;
}

/// In texels, y down, moved by whole tiles so that it lies near the unit tile.
UvTriangle texel_triangle(const Scan& scan, const ScanTriangle& triangle, int width, int height) {
  UvTriangle t;
  double u[3], v[3];
  for (int i = 0; i < 3; ++i) {
    const Vec2f uv = scan.uvs[scan.corners[triangle.corner[i]].uv];
    u[i] = uv.x;
    v[i] = uv.y;
  }
  const double tile_u = std::floor(std::min({u[0], u[1], u[2]})),
               tile_v = std::floor(std::min({v[0], v[1], v[2]}));
  for (int i = 0; i < 3; ++i) {
    t.x[i] = (u[i] - tile_u) * width;
    t.y[i] = (1 - (v[i] - tile_v)) * height;
  }
  return t;
}

/// Which side of an edge a point is on, exactly opposite for the same edge walked the other way: neighbours
/// agree on their shared edge.
class EdgeFunction {
 public:
  EdgeFunction(double ax, double ay, double bx, double by)
      : owns_(bx > ax || (bx == ax && by > ay)), x_(owns_ ? ax : bx), y_(owns_ ? ay : by) {
    dx_ = (owns_ ? bx : ax) - x_;
    dy_ = (owns_ ? by : ay) - y_;
  }
  /// Twice the signed area of (a, b, p).
  double at(double px, double py) const {
    const double value = dx_ * (py - y_) - dy_ * (px - x_);
    return owns_ ? value : -value;
  }
  /// A point on the edge belongs to the triangle for which the edge runs to the right, or straight down.
  bool is_inside(double px, double py) const {
    const double value = at(px, py);
    return value > 0 || (value == 0 && owns_);
  }

 private:
  bool owns_;
  double x_, y_, dx_, dy_;
};

/// Calls `hit(x, y)` for the texels whose centres the triangle covers; a centre on an edge belongs to one
/// side.
template <typename Hit>
void rasterise(const UvTriangle& triangle, const Hit& hit) {
  UvTriangle t = triangle;
  const double area = EdgeFunction(t.x[0], t.y[0], t.x[1], t.y[1]).at(t.x[2], t.y[2]);
  if (area == 0) return;
  if (area < 0) {
    std::swap(t.x[1], t.x[2]);
    std::swap(t.y[1], t.y[2]);
  }
  const EdgeFunction edges[3] = {
      {t.x[0], t.y[0], t.x[1], t.y[1]}, {t.x[1], t.y[1], t.x[2], t.y[2]}, {t.x[2], t.y[2], t.x[0], t.y[0]}};
  const auto low = [](const double* c) {
    return static_cast<int64_t>(std::ceil(std::min({c[0], c[1], c[2]}) - 0.5));
  };
  const auto high = [](const double* c) {
    return static_cast<int64_t>(std::floor(std::max({c[0], c[1], c[2]}) - 0.5));
  };
  const int64_t x_end = high(t.x), y_end = high(t.y);
  for (int64_t y = low(t.y); y <= y_end; ++y)
    for (int64_t x = low(t.x); x <= x_end; ++x) {
      const double px = static_cast<double>(x) + 0.5, py = static_cast<double>(y) + 0.5;
      if (edges[0].is_inside(px, py) && edges[1].is_inside(px, py) && edges[2].is_inside(px, py)) hit(x, y);
    }
}

double texel_tests(const UvTriangle& t) {
  const auto extent = [](const double* c) {
    return std::max({c[0], c[1], c[2]}) - std::min({c[0], c[1], c[2]}) + 1;
  };
  return extent(t.x) * extent(t.y);
}

bool share_a_point(const Scan& scan, const MeshTopology& topology, uint32_t f, uint32_t g) {
  for (uint32_t c = scan.face_begin[f]; c < scan.face_begin[f + 1]; ++c)
    for (uint32_t d = scan.face_begin[g]; d < scan.face_begin[g + 1]; ++d)
      if (topology.point_of_position[scan.corners[c].position] ==
          topology.point_of_position[scan.corners[d].position])
        return true;
  return false;
}

int64_t wrapped(int64_t i, int64_t n) {
  return (i % n + n) % n;
}

}  // namespace

UvRaster rasterise_uvs(const Scan& scan, const std::vector<ScanTriangle>& triangles,
                       const MeshTopology& topology, uint16_t material, int width_px, int height_px) {
  UvRaster raster;
  double tests = 0;
  std::vector<std::pair<UvTriangle, uint32_t>> drawn;
  for (const ScanTriangle& triangle : triangles) {
    if (scan.face_material[triangle.face] != material || !has_uvs(scan, triangle)) continue;
    drawn.emplace_back(texel_triangle(scan, triangle, width_px, height_px), triangle.face);
    tests += texel_tests(drawn.back().first);
  }
  if (!(tests < kMaxTexelTests)) return raster;
  raster.face.assign(static_cast<size_t>(width_px) * height_px, kNoFace);
  std::vector<bool> overlaps(raster.face.size(), false);
  for (const auto& [triangle, face] : drawn)
    rasterise(triangle, [&, face = face](int64_t x, int64_t y) {
      const auto texel = static_cast<size_t>(wrapped(y, height_px) * width_px + wrapped(x, width_px));
      uint32_t& owner = raster.face[texel];
      if (owner == kNoFace) {
        owner = face;
        ++raster.covered;
      } else if (!overlaps[texel] && owner != face && !share_a_point(scan, topology, owner, face)) {
        overlaps[texel] = true;
        ++raster.overlapping;
      }
    });
  return raster;
}

UvLayout measure_uv_layout(const Scan& scan, const std::vector<ScanTriangle>& triangles,
                           const MeshTopology& topology, uint16_t material, int size_px) {
  UvLayout layout;
  std::set<int> tiles;
  std::vector<double> face_area(scan.face_count(), 0);
  double area = 0, flipped = 0;
  for (const ScanTriangle& triangle : triangles) {
    if (scan.face_material[triangle.face] != material || !has_uvs(scan, triangle)) continue;
    const auto uv = [&](int i) { return scan.uvs[scan.corners[triangle.corner[i]].uv]; };
    const double ax = static_cast<double>(uv(1).x) - uv(0).x, ay = static_cast<double>(uv(1).y) - uv(0).y;
    const double bx = static_cast<double>(uv(2).x) - uv(0).x, by = static_cast<double>(uv(2).y) - uv(0).y;
    const double signed_area = 0.5 * (ax * by - ay * bx);
    area += std::abs(signed_area);
    flipped += std::max(0.0, -signed_area);
    face_area[triangle.face] += std::abs(signed_area);
  }
  for (uint32_t f = 0; f < scan.face_count(); ++f) {
    if (scan.face_material[f] != material) continue;
    ++layout.face_count;
    const uint32_t begin = scan.face_begin[f], end = scan.face_begin[f + 1];
    double u = 0, v = 0;
    bool has_uv = true;
    for (uint32_t c = begin; c < end && has_uv; ++c) {
      has_uv = scan.corners[c].uv != Corner::kNoUv;
      if (has_uv) u += scan.uvs[scan.corners[c].uv].x / static_cast<double>(end - begin);
      if (has_uv) v += scan.uvs[scan.corners[c].uv].y / static_cast<double>(end - begin);
    }
    layout.faces_without_uv += !has_uv;
    if (!has_uv) continue;
    layout.zero_area_faces += face_area[f] <= kZeroUvArea;
    layout.faces_outside += u < 0 || u > 1 || v < 0 || v > 1;
    if (u >= 0 && u < 10 && v >= 0 && v < 100 && tiles.size() < 100)
      tiles.insert(1001 + static_cast<int>(u) + 10 * static_cast<int>(v));
  }
  layout.tiles.assign(tiles.begin(), tiles.end());
  layout.flipped_share = area > 0 ? flipped / area : 0;
  const UvRaster raster = rasterise_uvs(scan, triangles, topology, material, size_px, size_px);
  layout.is_measured = !raster.face.empty();
  if (!layout.is_measured) return layout;
  layout.coverage = static_cast<double>(raster.covered) / static_cast<double>(raster.face.size());
  if (raster.covered > 0)
    layout.overlap_share = static_cast<double>(raster.overlapping) / static_cast<double>(raster.covered);
  return layout;
}

std::vector<uint32_t> uv_charts(const Scan& scan) {
  struct Edge {
    uint32_t a, b, face;
  };
  std::vector<Edge> edges;
  for (uint32_t f = 0; f < scan.face_count(); ++f) {
    const uint32_t begin = scan.face_begin[f], end = scan.face_begin[f + 1];
    for (uint32_t c = begin; c < end; ++c) {
      const uint32_t a = scan.corners[c].uv, b = scan.corners[c + 1 < end ? c + 1 : begin].uv;
      if (a != Corner::kNoUv && b != Corner::kNoUv) edges.push_back({std::min(a, b), std::max(a, b), f});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const Edge& l, const Edge& r) {
    return l.a != r.a ? l.a < r.a : l.b != r.b ? l.b < r.b : l.face < r.face;
  });
  DisjointSets charts(scan.face_count());
  for (size_t i = 1; i < edges.size(); ++i)
    if (edges[i].a == edges[i - 1].a && edges[i].b == edges[i - 1].b &&
        scan.face_material[edges[i].face] == scan.face_material[edges[i - 1].face])
      charts.join(edges[i].face, edges[i - 1].face);
  std::vector<uint32_t> chart_of_face;
  charts.number(chart_of_face);
  return chart_of_face;
}

}  // namespace ohb
