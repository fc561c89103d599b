#include "dataset/commands/uv_layout.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "dataset/surface/texel_rows.h"

namespace ohb::commands {
namespace {

/// No coarser grid tells anything.
constexpr int kCoarsest_px = 8;
/// UV area, of a tile, below which a face has none: far below a texel of an 8K picture.
constexpr double kZeroUvArea = 1e-12;

bool has_uvs(const Scan& scan, const ScanTriangle& triangle) {
  return scan.corners[triangle.corner[0]].uv != Corner::kNoUv &&
         scan.corners[triangle.corner[1]].uv != Corner::kNoUv &&
         scan.corners[triangle.corner[2]].uv != Corner::kNoUv;
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

/// A triangle's UVs, moved by whole tiles so that it lies near the unit tile.
struct DrawnTriangle {
  surface::TexelPoint uv[3];
  uint32_t face;
};

DrawnTriangle drawn_triangle(const Scan& scan, const ScanTriangle& triangle) {
  DrawnTriangle drawn{{}, triangle.face};
  for (int i = 0; i < 3; ++i) {
    const Vec2f uv = scan.uvs[scan.corners[triangle.corner[i]].uv];
    drawn.uv[i] = {uv.x, uv.y};
  }
  const auto [a, b, c] = drawn.uv;
  const surface::TexelPoint tile{std::floor(std::min({a.x, b.x, c.x})),
                                 std::floor(std::min({a.y, b.y, c.y}))};
  for (surface::TexelPoint& uv : drawn.uv) uv = uv - tile;
  return drawn;
}

surface::TexelTriangle in_texels(const DrawnTriangle& drawn, int width, int height) {
  const auto corner = [&](int i) {
    return surface::TexelPoint{drawn.uv[i].x * width, drawn.uv[i].y * height};
  };
  return {corner(0), corner(1), corner(2)};
}

double texel_tests(const std::vector<DrawnTriangle>& drawn, int width, int height) {
  double tests = 0;
  for (const DrawnTriangle& triangle : drawn) {
    const surface::TexelTriangle t = in_texels(triangle, width, height);
    tests += (t.high.x - t.low.x + 1) * (t.high.y - t.low.y + 1);
  }
  return tests;
}

/// Calls `hit(column, row)`, rows upwards, for the texels whose centres the triangle holds.
template <typename Hit>
void rasterise(const surface::TexelTriangle& triangle, const Hit& hit) {
  if (triangle.is_degenerate) return;
  const surface::TexelRows reach(triangle, 0);
  for (int64_t row = reach.rows().first; row <= reach.rows().last; ++row) {
    const surface::CentreRange columns = reach.columns(row);
    for (int64_t i = columns.first; i <= columns.last; ++i)
      if (triangle.owns({static_cast<double>(i) + 0.5, static_cast<double>(row) + 0.5})) hit(i, row);
  }
}

UvRaster rasterised(const Scan& scan, const MeshTopology& topology, const std::vector<DrawnTriangle>& drawn,
                    int width_px, int height_px) {
  UvRaster raster;
  raster.face.assign(static_cast<size_t>(width_px) * height_px, kNoFace);
  std::vector<bool> overlaps(raster.face.size(), false);
  for (const DrawnTriangle& triangle : drawn) {
    const uint32_t face = triangle.face;
    uint32_t known = face;  // the last owner, and whether the face shares a point with it
    bool shares = true;
    rasterise(in_texels(triangle, width_px, height_px), [&](int64_t x, int64_t row_up) {
      const int64_t row = height_px - 1 - wrapped(row_up, height_px);
      const auto texel = static_cast<size_t>(row * width_px + wrapped(x, width_px));
      uint32_t& owner = raster.face[texel];
      if (owner == kNoFace) {
        owner = face;
        ++raster.covered;
      } else if (!overlaps[texel] && owner != face) {
        if (owner != known) shares = share_a_point(scan, topology, owner, face);
        known = owner;
        if (shares) return;
        overlaps[texel] = true;
        ++raster.overlapping;
      }
    });
  }
  return raster;
}

/// A raster of a part of the size, each texel repeated over the block that it is the middle of.
UvRaster enlarged(const UvRaster& coarse, int coarse_width, int coarse_height, int width_px, int height_px) {
  UvRaster raster;
  raster.face.reserve(static_cast<size_t>(width_px) * height_px);
  for (int64_t y = 0; y < height_px; ++y)
    for (int64_t x = 0; x < width_px; ++x) {
      const int64_t row = y * coarse_height / height_px, column = x * coarse_width / width_px;
      raster.face.push_back(coarse.face[static_cast<size_t>(row * coarse_width + column)]);
      raster.covered += raster.face.back() != kNoFace;
    }
  if (coarse.covered > 0)
    raster.overlapping =
        static_cast<size_t>(static_cast<double>(coarse.overlapping) / static_cast<double>(coarse.covered) *
                            static_cast<double>(raster.covered));
  return raster;
}

/// What is_measured and the shares need of one material's triangles; gives their area in UV, face by face.
std::vector<double> measure_areas(const Scan& scan, const MaterialFaces& material, UvLayout& layout) {
  std::vector<double> areas(material.faces.size(), 0);
  double area = 0, flipped = 0;
  size_t at = 0;  // triangles and faces are both in the order of the faces
  for (const ScanTriangle& triangle : material.triangles) {
    while (material.faces[at] != triangle.face) ++at;
    if (!has_uvs(scan, triangle)) continue;
    const auto uv = [&](int i) { return scan.uvs[scan.corners[triangle.corner[i]].uv]; };
    const double ax = static_cast<double>(uv(1).x) - uv(0).x, ay = static_cast<double>(uv(1).y) - uv(0).y;
    const double bx = static_cast<double>(uv(2).x) - uv(0).x, by = static_cast<double>(uv(2).y) - uv(0).y;
    const double signed_area = 0.5 * (ax * by - ay * bx);
    area += std::abs(signed_area);
    flipped += std::max(0.0, -signed_area);
    areas[at] += std::abs(signed_area);
  }
  layout.flipped_share = area > 0 ? flipped / area : 0;
  return areas;
}

/// Counts what a face's own UVs tell.
void count_face(const Scan& scan, uint32_t face, double uv_area, UvLayout& layout, std::set<int>& tiles) {
  const uint32_t begin = scan.face_begin[face], end = scan.face_begin[face + 1];
  double u = 0, v = 0;
  for (uint32_t c = begin; c < end; ++c) {
    if (scan.corners[c].uv == Corner::kNoUv) {
      ++layout.faces_without_uv;
      return;
    }
    u += scan.uvs[scan.corners[c].uv].x / static_cast<double>(end - begin);
    v += scan.uvs[scan.corners[c].uv].y / static_cast<double>(end - begin);
  }
  layout.zero_area_faces += uv_area <= kZeroUvArea;
  layout.faces_outside += u < 0 || u > 1 || v < 0 || v > 1;
  if (u >= 0 && u < 10 && v >= 0 && v < 100 && tiles.size() < 100)
    tiles.insert(1001 + static_cast<int>(u) + 10 * static_cast<int>(v));
}

std::vector<DrawnTriangle> drawn_triangles(const Scan& scan, const std::vector<ScanTriangle>& triangles,
                                           uint16_t material) {
  std::vector<DrawnTriangle> drawn;
  for (const ScanTriangle& triangle : triangles)
    if (scan.face_material[triangle.face] == material && has_uvs(scan, triangle))
      drawn.push_back(drawn_triangle(scan, triangle));
  return drawn;
}

}  // namespace

UvRaster rasterise_uvs(const Scan& scan, const std::vector<ScanTriangle>& triangles,
                       const MeshTopology& topology, uint16_t material, const RasterSize& size) {
  const std::vector<DrawnTriangle> drawn = drawn_triangles(scan, triangles, material);
  int width = size.width_px, height = size.height_px;
  // Not "more than": the extent of a hostile triangle may be infinite.
  while (!(texel_tests(drawn, width, height) <= size.max_tests)) {
    if (width <= kCoarsest_px || height <= kCoarsest_px) return {};
    width = (width + 1) / 2;
    height = (height + 1) / 2;
  }
  const UvRaster raster = rasterised(scan, topology, drawn, width, height);
  return width == size.width_px ? raster : enlarged(raster, width, height, size.width_px, size.height_px);
}

std::vector<MaterialFaces> faces_of_materials(const Scan& scan, const std::vector<ScanTriangle>& triangles) {
  std::vector<MaterialFaces> materials(scan.materials.size());
  for (uint32_t f = 0; f < scan.face_count(); ++f) materials[scan.face_material[f]].faces.push_back(f);
  for (const ScanTriangle& triangle : triangles)
    materials[scan.face_material[triangle.face]].triangles.push_back(triangle);
  return materials;
}

UvLayout measure_uv_layout(const Scan& scan, const MaterialFaces& material, const MeshTopology& topology,
                           UvGrid grid) {
  UvLayout layout;
  layout.face_count = material.faces.size();
  if (material.faces.empty()) return layout;
  const std::vector<double> areas = measure_areas(scan, material, layout);
  std::set<int> tiles;
  for (size_t i = 0; i < material.faces.size(); ++i)
    count_face(scan, material.faces[i], areas[i], layout, tiles);
  layout.tiles.assign(tiles.begin(), tiles.end());
  const std::vector<DrawnTriangle> drawn =
      drawn_triangles(scan, material.triangles, scan.face_material[material.faces.front()]);
  int size_px = grid.size_px;
  while (!(texel_tests(drawn, size_px, size_px) <= grid.max_tests)) {
    size_px /= 2;
    if (size_px < kCoarsest_px) return layout;
  }
  const UvRaster raster = rasterised(scan, topology, drawn, size_px, size_px);
  layout.is_measured = true;
  layout.grid_px = size_px;
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

}  // namespace ohb::commands
