#include "dataset/people/fused.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>

#include "dataset/model/parallel.h"
#include "dataset/people/voxel_wrap.h"
#include "dataset/surface/padding.h"
#include "dataset/surface/texel_coverage.h"

namespace ohb::people {
namespace {

std::vector<SurfaceTriangle> triangles_of(const ScannedPerson& scan) {
  std::vector<SurfaceTriangle> triangles;
  for (uint32_t face = 0; face < scan.face_count(); ++face)
    for (uint32_t c = scan.face_begin[face] + 1; c + 1 < scan.face_begin[face + 1]; ++c)
      triangles.push_back({{scan.corners[scan.face_begin[face]].position, scan.corners[c].position,
                            scan.corners[c + 1].position},
                           face});
  return triangles;
}

Vec3f normal_of(const WrappedSurface& s, const std::array<uint32_t, 4>& q) {
  return cross(s.positions_cm[q[2]] - s.positions_cm[q[0]], s.positions_cm[q[3]] - s.positions_cm[q[1]]);
}

Vec3f middle_of(const WrappedSurface& s, const std::array<uint32_t, 4>& q) {
  return .25f * (s.positions_cm[q[0]] + s.positions_cm[q[1]] + s.positions_cm[q[2]] + s.positions_cm[q[3]]);
}

/// Draws the shell back onto the scan, but for a little that keeps thin cloth's two sides apart.
void draw_back(const SurfaceQuery& scan, float voxel_cm, WrappedSurface& surface) {
  constexpr float kShare = .9f;
  for (Vec3f& position : surface.positions_cm) {
    const SurfaceHit near = scan.nearest(position, 3 * voxel_cm);
    if (near.found) position += kShare * (scan.at(near) - position);
  }
}

/// Charts of faces that look along one axis, none over another of its chart.
class FlatCharts {
 public:
  FlatCharts(const WrappedSurface& surface, float voxel_cm) : surface_(surface), voxel_(voxel_cm) {
    for (const auto& quad : surface.quads) {
      const Vec3f n = normal_of(surface, quad);
      int axis = 0;
      for (int a = 1; a < 3; ++a)
        if (std::fabs(n[a]) > std::fabs(n[axis])) axis = a;
      side_.push_back(2 * axis + (n[axis] < 0));
    }
    find_neighbours();
    chart_of_.assign(surface.quads.size(), -1);
    for (uint32_t quad = 0; quad < surface.quads.size(); ++quad)
      if (chart_of_[quad] < 0) grow(quad);
  }

  size_t count() const { return charts_.size(); }
  const std::vector<uint32_t>& quads(size_t chart) const { return charts_[chart]; }
  /// The point as the chart's plane sees it, cm.
  Vec2f flat(uint32_t quad, Vec3f p) const {
    const int axis = side_[quad] / 2;
    const Vec2f at{p[(axis + 1) % 3], p[(axis + 2) % 3]};
    return side_[quad] % 2 == 0 ? at : Vec2f{-at.x, at.y};
  }

 private:
  void find_neighbours() {
    std::map<std::pair<uint32_t, uint32_t>, std::vector<uint32_t>> edges;
    for (uint32_t quad = 0; quad < surface_.quads.size(); ++quad)
      for (size_t k = 0; k < 4; ++k) {
        const uint32_t a = surface_.quads[quad][k], b = surface_.quads[quad][(k + 1) % 4];
        edges[std::minmax(a, b)].push_back(quad);
      }
    neighbours_.resize(surface_.quads.size());
    for (const auto& [edge, quads] : edges)
      for (const uint32_t a : quads)
        for (const uint32_t b : quads)
          if (a != b) neighbours_[a].push_back(b);
  }

  void grow(uint32_t seed) {
    const auto chart = static_cast<int>(charts_.size());
    charts_.emplace_back();
    std::map<std::pair<int, int>, std::vector<float>> depths;  // of the chart's faces, by place
    std::vector<uint32_t> queue{seed};
    for (size_t i = 0; i < queue.size(); ++i) {
      const uint32_t quad = queue[i];
      if (chart_of_[quad] >= 0) continue;
      const Vec3f middle = middle_of(surface_, surface_.quads[quad]);
      const Vec2f at = flat(quad, middle);
      const int x = static_cast<int>(std::floor(at.x / voxel_)),
                y = static_cast<int>(std::floor(at.y / voxel_));
      const float depth = middle[side_[quad] / 2];
      if (i > 0 && is_taken(depths, x, y, depth)) continue;
      chart_of_[quad] = chart;
      charts_.back().push_back(quad);
      depths[{x, y}].push_back(depth);
      for (const uint32_t next : neighbours_[quad])
        if (chart_of_[next] < 0 && side_[next] == side_[seed]) queue.push_back(next);
    }
  }

  bool is_taken(const std::map<std::pair<int, int>, std::vector<float>>& depths, int x, int y,
                float depth) const {
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const auto found = depths.find({x + dx, y + dy});
        if (found == depths.end()) continue;
        for (const float other : found->second)
          if (std::fabs(other - depth) > 3.5f * voxel_) return true;
      }
    return false;
  }

  const WrappedSurface& surface_;
  float voxel_;
  std::vector<int> side_;
  std::vector<int> chart_of_;
  std::vector<std::vector<uint32_t>> neighbours_, charts_;
};

/// The lowest corner and the size of a chart's box, in cm.
std::pair<Vec2f, Vec2f> box_of(const WrappedSurface& surface, const FlatCharts& charts, size_t chart) {
  Vec2f least{INFINITY, INFINITY}, most{-INFINITY, -INFINITY};
  for (const uint32_t quad : charts.quads(chart))
    for (const uint32_t v : surface.quads[quad]) {
      const Vec2f p = charts.flat(quad, surface.positions_cm[v]);
      least = {std::min(least.x, p.x), std::min(least.y, p.y)},
      most = {std::max(most.x, p.x), std::max(most.y, p.y)};
    }
  return {least, most - least};
}

/// Gives the fused scan its UVs and corners, chart by chart.
void lay_out(const WrappedSurface& surface, const FlatCharts& charts, int size_px, ScannedPerson& out) {
  constexpr float kGutter_px = 2;
  std::vector<Vec2f> low(charts.count()), size(charts.count());
  for (size_t c = 0; c < charts.count(); ++c) std::tie(low[c], size[c]) = box_of(surface, charts, c);
  std::vector<size_t> order(charts.count());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return size[a].y > size[b].y; });
  const auto pack = [&](float density) {
    std::vector<Vec2f> boxes;
    boxes.reserve(order.size());
    for (const size_t c : order) boxes.push_back(density * size[c] + Vec2f{2 * kGutter_px, 2 * kGutter_px});
    return pack_boxes(boxes, static_cast<float>(size_px));
  };
  float fits = 0, too_large = 64;
  for (int i = 0; i < 11; ++i) {
    const float middle = .5f * (fits + too_large);
    (pack(middle).empty() ? too_large : fits) = middle;
  }
  const std::vector<Vec2f> places = pack(fits);
  out.px_per_cm = fits;
  for (size_t i = 0; i < places.size(); ++i) {
    std::map<uint32_t, uint32_t> uv_of;
    for (const uint32_t quad : charts.quads(order[i])) {
      out.face_begin.push_back(static_cast<uint32_t>(out.corners.size()));
      for (const uint32_t v : surface.quads[quad]) {
        const auto known = uv_of.emplace(v, static_cast<uint32_t>(out.uvs.size()));
        if (known.second)
          out.uvs.push_back((1 / static_cast<float>(size_px)) *
                            (fits * (charts.flat(quad, surface.positions_cm[v]) - low[order[i]]) + places[i] +
                             Vec2f{kGutter_px, kGutter_px}));
        out.corners.push_back({v, known.first->second});
      }
    }
  }
  out.face_begin.push_back(static_cast<uint32_t>(out.corners.size()));
}

/// Looks up the scan's picture at what is nearest to points of the fused surface.
class Source {
 public:
  Source(const ScannedPerson& scan, const SurfaceQuery& query) : scan_(scan), query_(query) {}

  uint32_t face(Vec3f at) const { return query_.triangles()[near(at).triangle].face; }

  void colour(Vec3f at, float* out) const {
    const SurfaceHit hit = near(at);
    const SurfaceTriangle& triangle = query_.triangles()[hit.triangle];
    const float weight[3] = {1 - hit.u - hit.v, hit.u, hit.v};
    Vec2f uv;
    for (uint32_t c = scan_.face_begin[triangle.face]; c < scan_.face_begin[triangle.face + 1]; ++c)
      for (int k = 0; k < 3; ++k)
        if (scan_.corners[c].position == triangle.corner[k])
          uv = uv + weight[k] * scan_.uvs[scan_.corners[c].uv];
    const ByteImage& picture = scan_.picture;
    const auto x = static_cast<int>(uv.x * static_cast<float>(picture.width_px)),
               y = static_cast<int>((1 - uv.y) * static_cast<float>(picture.height_px));
    const auto column = static_cast<size_t>(std::clamp(x, 0, picture.width_px - 1)),
               row = static_cast<size_t>(std::clamp(y, 0, picture.height_px - 1));
    for (size_t c = 0; c < 3; ++c)
      out[c] =
          static_cast<float>(picture.values[3 * (row * static_cast<size_t>(picture.width_px) + column) + c]);
  }

 private:
  SurfaceHit near(Vec3f at) const {
    const SurfaceHit hit = query_.nearest(at, 5);
    return hit.found ? hit : query_.nearest(at, 1000);
  }

  const ScannedPerson& scan_;
  const SurfaceQuery& query_;
};

void paint(const Source& source, int size_px, ScannedPerson& out) {
  std::vector<surface::UvTriangle> triangles;
  std::vector<std::array<uint32_t, 3>> corners;
  for (uint32_t face = 0; face < out.face_count(); ++face)
    for (uint32_t k = 1; k < 3; ++k) {
      const uint32_t begin = out.face_begin[face];
      corners.push_back({begin, begin + k, begin + k + 1});
      surface::UvTriangle triangle;
      for (size_t i = 0; i < 3; ++i) triangle.uv[i] = out.uvs[out.corners[corners.back()[i]].uv];
      triangles.push_back(triangle);
    }
  const surface::TexelCoverage coverage = surface::cover_texels(triangles, size_px, size_px);
  Image image(size_px, size_px, 3);
  std::vector<uint8_t> is_covered(coverage.owner.size(), 0);
  parallel_for_each(0, size_px, [&](int y) {
    for (int x = 0; x < size_px; ++x) {
      const uint32_t owner = coverage.owner_of(x, y);
      if (owner == surface::TexelCoverage::kNone) continue;
      is_covered[static_cast<size_t>(y) * static_cast<size_t>(size_px) + static_cast<size_t>(x)] = 1;
      const surface::UvTriangle& t = triangles[owner];
      const Vec2f uv{(static_cast<float>(x) + .5f) / static_cast<float>(size_px),
                     1 - (static_cast<float>(y) + .5f) / static_cast<float>(size_px)};
      const Vec2f ab = t.uv[1] - t.uv[0], ac = t.uv[2] - t.uv[0], ap = uv - t.uv[0];
      const float area = cross(ab, ac);
      const float v = area != 0 ? std::clamp(cross(ap, ac) / area, 0.0f, 1.0f) : 0,
                  w = area != 0 ? std::clamp(cross(ab, ap) / area, 0.0f, 1 - v) : 0;
      const auto at = [&](size_t k) { return out.positions_cm[out.corners[corners[owner][k]].position]; };
      source.colour((1 - v - w) * at(0) + v * at(1) + w * at(2), image.pixel(x, y));
    }
  });
  surface::pad(image, is_covered);
  out.picture = ByteImage(size_px, size_px, 3);
  for (size_t i = 0; i < image.values.size(); ++i)
    out.picture.values[i] = static_cast<uint8_t>(std::lround(std::clamp(image.values[i], 0.0f, 255.0f)));
}

}  // namespace

ScannedPerson fused(const ScannedPerson& scan, float voxel_cm) {
  const std::vector<SurfaceTriangle> triangles = triangles_of(scan);
  const SurfaceQuery query(scan.positions_cm, triangles);
  WrappedSurface surface = wrap(scan.positions_cm, triangles, voxel_cm);
  draw_back(query, voxel_cm, surface);
  ScannedPerson out;
  out.unseen_faces = scan.unseen_faces;
  const int size_px = scan.picture.width_px;
  lay_out(surface, FlatCharts(surface, voxel_cm), size_px, out);
  out.positions_cm = std::move(surface.positions_cm);
  const Source source(scan, query);
  for (uint32_t face = 0; face < out.face_count(); ++face) {
    Vec3f middle;
    for (uint32_t c = out.face_begin[face]; c < out.face_begin[face + 1]; ++c)
      middle += .25f * out.positions_cm[out.corners[c].position];
    const uint32_t from = source.face(middle);
    out.face_class.push_back(scan.face_class[from]);
    out.part_of_face.push_back(scan.part_of_face[from]);
  }
  paint(source, size_px, out);
  return out;
}

}  // namespace ohb::people
