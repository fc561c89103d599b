#include "bake/seam_fill.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "bake/source_bake.h"

namespace ohb {
namespace {

int wrapped(int i, int size) {
  if (i >= 0 && i < size) return i;
  const int rest = i % size;
  return rest < 0 ? rest + size : rest;
}

constexpr float kShortest_px = 1e-3f;

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

SeamBand::Placed::Placed(const SeamSide& side, int width_px, int height_px) {
  const auto in_px = [&](Vec2f uv) {
    return Vec2f{uv.x * static_cast<float>(width_px) - 0.5f,
                 (1 - uv.y) * static_cast<float>(height_px) - 0.5f};
  };
  from = in_px(side.uv[0]);
  to = in_px(side.uv[1]);
  const Vec2f edge = to - from, to_apex = in_px(side.apex) - from;
  length_px = std::sqrt(dot(edge, edge));
  const Vec2f left{-edge.y, edge.x};
  const float scale = (dot(left, to_apex) >= 0 ? 1.0f : -1.0f) / std::max(length_px, 1e-20f);
  inward = left * scale;
}

SeamBand::Beside::Beside(const Placed& edge, Vec2f point) {
  const Vec2f direction = edge.to - edge.from, to_point = point - edge.from;
  outward_px = -dot(to_point, edge.inward);
  along = dot(to_point, direction) / (edge.length_px * edge.length_px);
  const float past_end = (along - std::clamp(along, 0.0f, 1.0f)) * edge.length_px;
  squared_distance = outward_px * outward_px + past_end * past_end;
}

/// Some rows of the map and the sides that reach them, in ascending order: one task.
struct SeamBand::RowBand {
  int first_row, last_row;
  std::vector<uint32_t> sides;
};

namespace {

/// Whole numbers within kSeamBand_px of both.
struct Reach {
  int first, last;
  Reach(float a, float b)
      : first(static_cast<int>(std::floor(std::min(a, b))) - kSeamBand_px),
        last(static_cast<int>(std::ceil(std::max(a, b))) + kSeamBand_px) {}
};

}  // namespace

std::vector<SeamBand::RowBand> SeamBand::row_bands() const {
  constexpr int kRows = 64;
  std::vector<RowBand> bands;
  for (int row = 0; row < height_px_; row += kRows)
    bands.push_back({row, std::min(row + kRows, height_px_) - 1, {}});
  for (uint32_t s = 0; s < placed_.size(); ++s) {
    if (!(placed_[s].length_px > kShortest_px && placed_[s ^ 1].length_px > kShortest_px)) continue;
    const Reach rows(placed_[s].from.y, placed_[s].to.y);
    for (int y = rows.first; y <= rows.last;) {
      RowBand& band = bands[wrapped(y, height_px_) / kRows];
      if (band.sides.empty() || band.sides.back() != s) band.sides.push_back(s);
      y += band.last_row - wrapped(y, height_px_) + 1;
    }
  }
  return bands;
}

void SeamBand::claim_texels(const RowBand& band, const std::vector<uint8_t>& is_face) {
  std::vector<float> squared_distance(static_cast<size_t>(width_px_) * (band.last_row - band.first_row + 1),
                                      float(kSeamBand_px) * kSeamBand_px);
  for (uint32_t s : band.sides) {
    const Placed& edge = placed_[s];
    const Reach rows(edge.from.y, edge.to.y), columns(edge.from.x, edge.to.x);
    for (int y = rows.first; y <= rows.last; ++y) {
      const int row = wrapped(y, height_px_);
      if (row < band.first_row || row > band.last_row) continue;
      for (int x = columns.first; x <= columns.last; ++x) {
        const int column = wrapped(x, width_px_);
        const size_t index = static_cast<size_t>(row) * width_px_ + column;
        if (is_face[index]) continue;
        const Beside beside(edge, {static_cast<float>(x), static_cast<float>(y)});
        float& nearest = squared_distance[static_cast<size_t>(row - band.first_row) * width_px_ + column];
        if (!(beside.outward_px > 0 && beside.squared_distance < nearest)) continue;
        nearest = beside.squared_distance;
        side_[index] = s;
      }
    }
  }
}

SeamBand::SeamBand(const std::vector<Seam>& seams, const std::vector<uint8_t>& is_face, int width_px,
                   int height_px)
    : seams_(seams), width_px_(width_px), height_px_(height_px), side_(is_face.size(), kNone) {
  for (const Seam& seam : seams)
    for (const SeamSide& side : seam.side) placed_.emplace_back(side, width_px, height_px);
  const std::vector<RowBand> bands = row_bands();
  tbb::parallel_for(size_t{0}, bands.size(), [&](size_t b) { claim_texels(bands[b], is_face); });
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
      const Placed &edge = placed_[side_[index]], &other = placed_[side_[index] ^ 1];
      // The copy of the map in which the edge lies.
      const Vec2f middle = 0.5f * (edge.from + edge.to);
      const float x = static_cast<float>(column), y = static_cast<float>(row);
      const Vec2f texel{x + std::round((middle.x - x) / float(width_px_)) * float(width_px_),
                        y + std::round((middle.y - y) / float(height_px_)) * float(height_px_)};
      const Beside beside(edge, texel);
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
