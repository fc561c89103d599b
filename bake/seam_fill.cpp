#include "bake/seam_fill.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "bake/source_bake.h"

namespace ohb::bake {
namespace {

int wrapped(int i, int size) {
  if (i >= 0 && i < size) return i;
  const int rest = i % size;
  return rest < 0 ? rest + size : rest;
}

constexpr float kShortest_px = 1e-3f;

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

/// The four texels of a bilinear lookup, by rows.
struct Reads {
  size_t texel[4];
  Reads(int x, int y, int width_px, int height_px) {
    const int columns[2] = {x, x + 1 < width_px ? x + 1 : 0}, rows[2] = {y, y + 1 < height_px ? y + 1 : 0};
    for (int k = 0; k < 4; ++k) texel[k] = static_cast<size_t>(rows[k / 2]) * width_px + columns[k % 2];
  }
};

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

/// The side that each texel of the rows belongs to, or kNone.
std::vector<uint32_t> SeamBand::claim_texels(const RowBand& band, const std::vector<uint8_t>& is_face) const {
  const size_t count = static_cast<size_t>(width_px_) * (band.last_row - band.first_row + 1);
  std::vector<uint32_t> side_of(count, kNone);
  std::vector<float> squared_distance(count, float(kSeamBand_px) * kSeamBand_px);
  for (uint32_t s : band.sides) {
    const Placed& edge = placed_[s];
    const Reach rows(edge.from.y, edge.to.y), columns(edge.from.x, edge.to.x);
    for (int y = rows.first; y <= rows.last; ++y) {
      const int row = wrapped(y, height_px_);
      if (row < band.first_row || row > band.last_row) continue;
      for (int x = columns.first; x <= columns.last; ++x) {
        const int column = wrapped(x, width_px_);
        if (is_face[static_cast<size_t>(row) * width_px_ + column]) continue;
        const Beside beside(edge, {static_cast<float>(x), static_cast<float>(y)});
        const size_t i = static_cast<size_t>(row - band.first_row) * width_px_ + column;
        if (!(beside.outward_px > 0 && beside.squared_distance < squared_distance[i])) continue;
        squared_distance[i] = beside.squared_distance;
        side_of[i] = s;
      }
    }
  }
  return side_of;
}

/// The texels of the rows whose other side is wholly covered by faces.
std::vector<SeamBand::Carried> SeamBand::carried_in(const RowBand& band,
                                                    const std::vector<uint8_t>& is_face) const {
  const std::vector<uint32_t> side_of = claim_texels(band, is_face);
  std::vector<Carried> carried;
  for (size_t i = 0; i < side_of.size(); ++i) {
    if (side_of[i] == kNone) continue;
    const Placed &edge = placed_[side_of[i]], &other = placed_[side_of[i] ^ 1];
    const int row = band.first_row + static_cast<int>(i / width_px_),
              column = static_cast<int>(i % width_px_);
    // The copy of the map in which the edge lies.
    const Vec2f middle = 0.5f * (edge.from + edge.to);
    const float x = static_cast<float>(column), y = static_cast<float>(row);
    const Vec2f texel{x + std::round((middle.x - x) / float(width_px_)) * float(width_px_),
                      y + std::round((middle.y - y) / float(height_px_)) * float(height_px_)};
    const Beside beside(edge, texel);
    const float outward = beside.outward_px * other.length_px / edge.length_px;
    const Vec2f from = other.from + beside.along * (other.to - other.from) + outward * other.inward;
    const float x_whole = std::floor(from.x), y_whole = std::floor(from.y);
    Carried to;
    to.texel = static_cast<uint32_t>(static_cast<size_t>(row) * width_px_ + column);
    to.side = side_of[i];
    to.x = static_cast<uint16_t>(wrapped(static_cast<int>(x_whole), width_px_));
    to.y = static_cast<uint16_t>(wrapped(static_cast<int>(y_whole), height_px_));
    to.right = from.x - x_whole;
    to.down = from.y - y_whole;
    to.along = std::clamp(beside.along, 0.0f, 1.0f);
    const Reads reads(to.x, to.y, width_px_, height_px_);
    if (std::all_of(reads.texel, reads.texel + 4, [&](size_t t) { return is_face[t] != 0; }))
      carried.push_back(to);
  }
  return carried;
}

SeamBand::SeamBand(const std::vector<Seam>& seams, const std::vector<uint8_t>& is_face, int width_px,
                   int height_px)
    : seams_(seams), width_px_(width_px), height_px_(height_px) {
  for (const Seam& seam : seams)
    for (const SeamSide& side : seam.side) placed_.emplace_back(side, width_px, height_px);
  const std::vector<RowBand> bands = row_bands();
  std::vector<std::vector<Carried>> carried(bands.size());
  tbb::parallel_for(size_t{0}, bands.size(), [&](size_t b) { carried[b] = carried_in(bands[b], is_face); });
  for (const std::vector<Carried>& rows : carried) carried_.insert(carried_.end(), rows.begin(), rows.end());
}

Vec3f SeamBand::turned(Vec3f normal, const Carried& to) const {
  const Seam& seam = seams_[to.side / 2];
  const SeamSide &here = seam.side[to.side % 2], &there = seam.side[1 - to.side % 2];
  const SeamFrame f = frame_at(there, to.along), g = frame_at(here, to.along);
  return to_tangent_space(to_model(f, normal), g.tangent, g.normal, here.sign);
}

std::vector<uint8_t> SeamBand::fill(Image& map, const std::vector<uint8_t>& is_covered,
                                    bool is_normals) const {
  std::vector<uint8_t> is_filled = is_covered;
  const auto fill_one = [&](const Carried& to) {
    const Reads reads(to.x, to.y, width_px_, height_px_);
    const float weights[4] = {(1 - to.right) * (1 - to.down), to.right * (1 - to.down),
                              (1 - to.right) * to.down, to.right * to.down};
    if (!std::all_of(reads.texel, reads.texel + 4, [&](size_t t) { return is_covered[t] != 0; })) return;
    float* const out = &map.values[size_t{to.texel} * map.channels];
    for (int c = 0; c < map.channels; ++c) {
      float value = 0;
      for (int k = 0; k < 4; ++k) value += weights[k] * map.values[reads.texel[k] * map.channels + c];
      out[c] = value;
    }
    if (is_normals) {
      const Vec3f normal = turned({out[0], out[1], out[2]}, to);
      for (int c = 0; c < 3; ++c) out[c] = normal[c];
    }
    is_filled[to.texel] = 1;
  };
  tbb::parallel_for(tbb::blocked_range<size_t>(0, carried_.size(), 4096),
                    [&](const tbb::blocked_range<size_t>& range) {
                      for (size_t i = range.begin(); i < range.end(); ++i) fill_one(carried_[i]);
                    });
  return is_filled;
}

}  // namespace ohb::bake
