#include "bake/source_bake.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "bake/jobs.h"
#include "bake/uv_charts.h"

namespace ohb::bake {
namespace {

/// A triangle of the low mesh as the pass wants it.
struct LowTriangle {
  surface::TexelTriangle in_texels;
  Vec3f position[3], normal[3], tangent[3], offset[3];
  float sign[3];
  Vec3f across, up;  // cm that one texel to the right and one up make
  Vec3f face_normal;
};

/// The derivatives of position by texel coordinates; 0 for triangles without UV area.
void set_steps(LowTriangle& triangle) {
  const surface::TexelPoint* const c = triangle.in_texels.corner;
  const surface::TexelPoint a = c[1] - c[0], b = c[2] - c[0];
  const double area = surface::difference_of_products(a.x, b.y, a.y, b.x);
  if (area == 0) return;
  const Vec3f ab = triangle.position[1] - triangle.position[0];
  const Vec3f ac = triangle.position[2] - triangle.position[0];
  triangle.across = static_cast<float>(b.y / area) * ab - static_cast<float>(a.y / area) * ac;
  triangle.up = static_cast<float>(a.x / area) * ac - static_cast<float>(b.x / area) * ab;
}

/// A texel shows no more than its chart, however far its steps reach: a chart of a hundredth of a texel would
/// else show the mean of all around it.
void limit_steps(LowTriangle& triangle, float most_cm) {
  for (Vec3f* step : {&triangle.across, &triangle.up})
    if (const float size = length(*step); size > most_cm) *step = (most_cm / size) * *step;
}

class Pass {
 public:
  Pass(const Model& low, const std::vector<uint32_t>& triangles, const std::vector<surface::UvTriangle>& uvs,
       const surface::TexelCoverage& coverage, const SourceBake& bake)
      : coverage_(coverage), bake_(bake) {
    low_.reserve(triangles.size());
    const UvCharts charts = find_charts(low, triangles, uvs, coverage.width_px, coverage.height_px);
    for (size_t i = 0; i < triangles.size(); ++i) {
      low_.push_back(low_triangle(low, triangles[i], uvs[i]));
      limit_steps(low_.back(), charts.charts[charts.chart_of[i]].diagonal_cm);
    }
    const int width = coverage.width_px, height = coverage.height_px;
    const auto make = [&](Image& map, int channels) { map = Image(width, height, channels); };
    run_side_by_side({[&] { make(maps_.albedo, 3); }, [&] { make(maps_.normal, 3); },
                      [&] { make(maps_.displacement, 1); }, [&] { make(maps_.height, 1); }});
    if (bake.surface->has_alpha()) make(maps_.alpha, 1);
    if (bake.wants_object_normals) make(maps_.object_normal, 3);
    maps_.results.assign(coverage.owner.size(), RayResult::kNoFace);
  }

  SourceMaps run() {
    const int columns = (coverage_.width_px + kTile_px - 1) / kTile_px;
    const int rows = (coverage_.height_px + kTile_px - 1) / kTile_px;
    tbb::parallel_for(0, columns * rows,
                      [&](int tile) { bake_tile(kTile_px * (tile % columns), kTile_px * (tile / columns)); });
    return std::move(maps_);
  }

 private:
  /// Texels of a square show the same few triangles of the source, which then stay in the cache.
  static constexpr int kTile_px = 32;

  struct Lane {
    const LowTriangle* triangle;
    float weights[3];
    int x, row;
    template <typename Value>
    Value mean_of(const Value* corners) const {
      return weights[0] * corners[0] + weights[1] * corners[1] + weights[2] * corners[2];
    }
  };

  LowTriangle low_triangle(const Model& low, uint32_t index, const surface::UvTriangle& uv) const {
    const ModelTriangle& from = low.triangles[index];
    LowTriangle triangle{
        surface::to_texel_space(uv, coverage_.width_px, coverage_.height_px), {}, {}, {}, {}, {}, {}, {}, {}};
    for (int c = 0; c < 3; ++c) {
      const uint32_t p = from.position[c];
      triangle.position[c] = low.positions_cm[p];
      triangle.normal[c] = bake_.frames->normals[p];
      triangle.offset[c] = bake_.cage_offset.empty() ? bake_.frames->normals[p] : bake_.cage_offset[p];
      triangle.tangent[c] = bake_.frames->tangents[3 * size_t{index} + c].tangent;
      triangle.sign[c] = bake_.frames->tangents[3 * size_t{index} + c].sign;
    }
    triangle.face_normal = normalised(
        cross(triangle.position[1] - triangle.position[0], triangle.position[2] - triangle.position[0]));
    set_steps(triangle);
    return triangle;
  }

  void bake_tile(int left, int top) {
    RayPacket packet;
    packet.inward_cm = bake_.inward_cm;
    Lane lanes[RayPacket::kSize];
    for (int row = top; row < std::min(top + kTile_px, coverage_.height_px); ++row)
      for (int x = left; x < std::min(left + kTile_px, coverage_.width_px); ++x) {
        const uint32_t owner = coverage_.owner_of(x, row);
        if (owner == surface::TexelCoverage::kNone) continue;
        aim(low_[owner], x, row, packet, lanes[packet.count]);
        if (++packet.count == RayPacket::kSize) finish(packet, lanes);
      }
    if (packet.count > 0) finish(packet, lanes);
  }

  void aim(const LowTriangle& triangle, int x, int row, RayPacket& packet, Lane& lane) const {
    const surface::NearestPoint nearest =
        surface::nearest_point_of_texel(triangle.in_texels, coverage_.width_px, coverage_.height_px, x, row);
    lane = {&triangle, {}, x, row};
    for (int c = 0; c < 3; ++c) lane.weights[c] = static_cast<float>(nearest.weights[c]);
    const Vec3f offset = lane.mean_of(triangle.offset);
    const float size = length(offset);
    const int i = packet.count;
    packet.origin[i] = lane.mean_of(triangle.position);
    packet.direction[i] = size > 0 ? offset / size : triangle.face_normal;
    packet.outward_cm[i] = bake_.cage_offset.empty() ? bake_.outward_cm : size;
  }

  void finish(RayPacket& packet, const Lane* lanes) {
    SourcePoint points[RayPacket::kSize];
    find_source(*bake_.surface, packet, points);
    for (int i = 0; i < packet.count; ++i) store(lanes[i], packet.direction[i], points[i]);
    packet.count = 0;
  }

  void store(const Lane& lane, Vec3f direction, const SourcePoint& point) {
    const int x = lane.x, row = lane.row;
    maps_.results[static_cast<size_t>(row) * coverage_.width_px + x] = point.result;
    if (point.result != RayResult::kHit && point.result != RayResult::kNearest) return;
    const LowTriangle& triangle = *lane.triangle;
    const SourceSample sample =
        bake_.surface->sample(point.triangle, point.u, point.v, triangle.across, triangle.up, direction);
    const Vec3f normal = to_tangent_space(sample.normal, lane.mean_of(triangle.tangent),
                                          lane.mean_of(triangle.normal), triangle.sign[0]);
    for (int c = 0; c < 3; ++c) {
      maps_.albedo.pixel(x, row)[c] = sample.albedo[c];
      maps_.normal.pixel(x, row)[c] = normal[c];
      if (bake_.wants_object_normals) maps_.object_normal.pixel(x, row)[c] = sample.normal[c];
    }
    if (bake_.surface->has_alpha()) *maps_.alpha.pixel(x, row) = sample.alpha;
    *maps_.displacement.pixel(x, row) = bake_.surface->position(point.triangle, point.u, point.v).z;
    *maps_.height.pixel(x, row) = point.distance_cm;
  }

  const surface::TexelCoverage& coverage_;
  const SourceBake& bake_;
  std::vector<LowTriangle> low_;
  SourceMaps maps_;
};

}  // namespace

Vec3f to_tangent_space(Vec3f direction, Vec3f tangent, Vec3f normal, float sign) {
  const Vec3f bitangent = sign * cross(normal, tangent);
  const Vec3f across = cross(bitangent, normal), up = cross(normal, tangent), out = cross(tangent, bitangent);
  const float volume = dot(tangent, across);
  if (!(std::fabs(volume) > 1e-12f)) return {0, 0, 1};
  const Vec3f local{dot(direction, across) / volume, dot(direction, up) / volume,
                    dot(direction, out) / volume};
  const float squared = dot(local, local);
  return squared > 0 && std::isfinite(squared) ? local / std::sqrt(squared) : Vec3f{0, 0, 1};
}

SourceMaps bake_from_source(const Model& low, const std::vector<uint32_t>& triangles,
                            const std::vector<surface::UvTriangle>& uvs,
                            const surface::TexelCoverage& coverage, const SourceBake& bake) {
  return Pass(low, triangles, uvs, coverage, bake).run();
}

}  // namespace ohb::bake
