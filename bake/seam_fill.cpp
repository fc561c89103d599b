#include "bake/seam_fill.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "bake/source_bake.h"

namespace ohb {
namespace {

int wrapped(int i, int size) {
  const int rest = i % size;
  return rest < 0 ? rest + size : rest;
}

/// Texel space, y down, centres at whole numbers.
struct Placed {
  Vec2f from, to, inward;  // inward: unit, into the triangle
  float length_px;
};

Placed place(const SeamSide& side, int width_px, int height_px) {
  const auto in_px = [&](Vec2f uv) {
    return Vec2f{uv.x * static_cast<float>(width_px) - 0.5f,
                 (1 - uv.y) * static_cast<float>(height_px) - 0.5f};
  };
  Placed placed;
  placed.from = in_px(side.uv[0]);
  placed.to = in_px(side.uv[1]);
  const Vec2f edge = placed.to - placed.from, to_apex = in_px(side.apex) - placed.from;
  placed.length_px = std::sqrt(dot(edge, edge));
  const Vec2f left{-edge.y, edge.x};
  const float scale = (dot(left, to_apex) >= 0 ? 1.0f : -1.0f) / std::max(placed.length_px, 1e-20f);
  placed.inward = left * scale;
  return placed;
}

constexpr float kShortest_px = 1e-3f;

/// A point beside an edge: how far outwards, how far along (0 to 1 on it), how far from it.
struct Beside {
  float outward_px, along, squared_distance;
};

Beside beside_of(const Placed& edge, Vec2f point) {
  const Vec2f direction = edge.to - edge.from, to_point = point - edge.from;
  const float outward = -dot(to_point, edge.inward);
  const float along = dot(to_point, direction) / (edge.length_px * edge.length_px);
  const float past_end = (along - std::clamp(along, 0.0f, 1.0f)) * edge.length_px;
  return {outward, along, outward * outward + past_end * past_end};
}

/// The bilinear lookup at a point of texel space; false if one of its texels is not covered.
bool read_covered(const Image& map, const std::vector<uint8_t>& is_covered, Vec2f at, Vec3f& value) {
  const float x_whole = std::floor(at.x), y_whole = std::floor(at.y);
  const float fx = at.x - x_whole, fy = at.y - y_whole;
  const float wx[2] = {1 - fx, fx}, wy[2] = {1 - fy, fy};
  for (int k = 0; k < 4; ++k) {
    const int x = wrapped(static_cast<int>(x_whole) + k % 2, map.width_px);
    const int y = wrapped(static_cast<int>(y_whole) + k / 2, map.height_px);
    if (!is_covered[static_cast<size_t>(y) * map.width_px + x]) return false;
    for (int c = 0; c < map.channels; ++c) value[c] += wx[k % 2] * wy[k / 2] * map.pixel(x, y)[c];
  }
  return true;
}

}  // namespace

SeamBand::SeamBand(const std::vector<Seam>& seams, const std::vector<uint8_t>& is_face, int width_px,
                   int height_px)
    : seams_(seams), width_px_(width_px), height_px_(height_px), side_(is_face.size(), kNone) {
  std::vector<float> squared_distance(is_face.size(), float(kSeamBand_px) * kSeamBand_px);
  for (uint32_t s = 0; s < 2 * seams.size(); ++s) {
    const Placed edge = place(seams[s / 2].side[s % 2], width_px, height_px);
    const Placed other = place(seams[s / 2].side[1 - s % 2], width_px, height_px);
    if (!(edge.length_px > kShortest_px && other.length_px > kShortest_px)) continue;
    const auto first = [](float a, float b) {
      return static_cast<int>(std::floor(std::min(a, b))) - kSeamBand_px;
    };
    const auto last = [](float a, float b) {
      return static_cast<int>(std::ceil(std::max(a, b))) + kSeamBand_px;
    };
    for (int y = first(edge.from.y, edge.to.y); y <= last(edge.from.y, edge.to.y); ++y)
      for (int x = first(edge.from.x, edge.to.x); x <= last(edge.from.x, edge.to.x); ++x) {
        const size_t index = static_cast<size_t>(wrapped(y, height_px)) * width_px + wrapped(x, width_px);
        if (is_face[index]) continue;
        const Beside beside = beside_of(edge, {static_cast<float>(x), static_cast<float>(y)});
        if (!(beside.outward_px > 0 && beside.squared_distance < squared_distance[index])) continue;
        squared_distance[index] = beside.squared_distance;
        side_[index] = s;
      }
  }
}

std::vector<uint8_t> SeamBand::fill(Image& map, const std::vector<uint8_t>& is_covered,
                                    bool is_normals) const {
  std::vector<uint8_t> is_filled = is_covered;
  tbb::parallel_for(0, height_px_, [&](int row) {
    for (int column = 0; column < width_px_; ++column) {
      const size_t index = static_cast<size_t>(row) * width_px_ + column;
      if (side_[index] == kNone) continue;
      const Seam& seam = seams_[side_[index] / 2];
      const SeamSide &here = seam.side[side_[index] % 2], &there = seam.side[1 - side_[index] % 2];
      const Placed edge = place(here, width_px_, height_px_), other = place(there, width_px_, height_px_);
      // The copy of the map in which the edge lies.
      const Vec2f middle = 0.5f * (edge.from + edge.to);
      const float x = static_cast<float>(column), y = static_cast<float>(row);
      const Vec2f texel{x + std::round((middle.x - x) / float(width_px_)) * float(width_px_),
                        y + std::round((middle.y - y) / float(height_px_)) * float(height_px_)};
      const Beside beside = beside_of(edge, texel);
      const float outward = beside.outward_px * other.length_px / edge.length_px;
      const Vec2f from = other.from + beside.along * (other.to - other.from) + outward * other.inward;
      Vec3f value;
      if (!read_covered(map, is_covered, from, value)) continue;
      if (is_normals) {
        const float along = std::clamp(beside.along, 0.0f, 1.0f);
        const SeamFrame f = frame_at(there, along), g = frame_at(here, along);
        value = to_tangent_space(value.x * f.tangent + value.y * f.bitangent + value.z * f.normal, g.tangent,
                                 g.normal, here.sign);
      }
      for (int c = 0; c < map.channels; ++c) map.values[index * map.channels + c] = value[c];
      is_filled[index] = 1;
    }
  });
  return is_filled;
}

}  // namespace ohb
