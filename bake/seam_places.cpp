#include "bake/seam_places.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace ohb::bake {
namespace {

/// Pieces shorter than this along the longer side are part of their neighbour; of others that are short a
/// quadratic cannot rise far above its ends.
constexpr double kShortestPiece_px = 1.0 / 256, kShortestWithMiddle_px = 1.0 / 8;

/// Where coordinates from `a` to `b`, in texels, pass a texel's middle: there bilinear weights change.
void add_crossings(double a, double b, std::vector<double>& along) {
  const double low = std::min(a, b), high = std::max(a, b);
  for (double middle = std::floor(low - 0.5) + 1.5; middle < high; ++middle)
    along.push_back((middle - a) / (b - a));
}

/// From 0 to 1.
std::vector<float> places_along(const Seam& seam, int width_px, int height_px) {
  std::vector<double> ends;
  double longer_px = 0;
  for (const SeamSide& side : seam.side) {
    const double x[2] = {double(side.uv[0].x) * width_px, double(side.uv[1].x) * width_px};
    const double y[2] = {(1.0 - side.uv[0].y) * height_px, (1.0 - side.uv[1].y) * height_px};
    add_crossings(x[0], x[1], ends);
    add_crossings(y[0], y[1], ends);
    longer_px = std::max(longer_px, std::hypot(x[1] - x[0], y[1] - y[0]));
  }
  std::sort(ends.begin(), ends.end());
  const double shortest = longer_px > 0 ? kShortestPiece_px / longer_px : 1;
  std::vector<float> along{0};
  double last = 0;
  const auto add_piece = [&](double end) {
    if ((end - last) * longer_px >= kShortestWithMiddle_px)
      along.push_back(static_cast<float>(0.5 * (last + end)));
    along.push_back(static_cast<float>(end));
    last = end;
  };
  for (double end : ends)
    if (end - last >= shortest && 1 - end >= shortest) add_piece(end);
  add_piece(1);
  return along;
}

/// Numbers set bits in ascending order.
class Ranks {
 public:
  explicit Ranks(size_t size) : words_((size + 63) / 64), before_(words_.size()) {}
  void set(uint32_t i) { words_[i / 64] |= uint64_t{1} << (i % 64); }
  std::vector<uint32_t> count() {
    std::vector<uint32_t> all;
    for (size_t w = 0; w < words_.size(); ++w) {
      before_[w] = static_cast<uint32_t>(all.size());
      for (uint64_t left = words_[w]; left != 0; left &= left - 1)
        all.push_back(static_cast<uint32_t>(64 * w + static_cast<size_t>(__builtin_ctzll(left))));
    }
    return all;
  }
  uint32_t of(uint32_t i) const {
    const uint64_t below = words_[i / 64] & ((uint64_t{1} << (i % 64)) - 1);
    return before_[i / 64] + static_cast<uint32_t>(__builtin_popcountll(below));
  }

 private:
  std::vector<uint64_t> words_;
  std::vector<uint32_t> before_;
};

SeamPlace place_at(const Seam& seam, uint32_t index, float along, int width_px, int height_px) {
  SeamPlace place;
  place.seam = index;
  place.along = along;
  for (int k = 0; k < 2; ++k) {
    const SeamLookup lookup = lookup_at(seam.side[k], along, 0, width_px, height_px);
    for (int j = 0; j < 4; ++j) {
      place.texel[k][j] = static_cast<uint32_t>(lookup.row[j / 2] * width_px + lookup.column[j % 2]);
      place.weight[k][j] = lookup.weight[j / 2][j % 2];
    }
  }
  return place;
}

}  // namespace

SeamPlaces::SeamPlaces(const std::vector<Seam>& seams, int width_px, int height_px,
                       const std::vector<SeamPoint>& more) {
  auto next = more.begin();
  for (uint32_t s = 0; s < seams.size(); ++s) {
    std::vector<float> along = places_along(seams[s], width_px, height_px);
    const size_t own = along.size();
    for (; next != more.end() && next->first == s; ++next) along.push_back(next->second);
    if (along.size() > own) std::sort(along.begin(), along.end());
    for (float a : along) places.push_back(place_at(seams[s], s, a, width_px, height_px));
  }
  link_texels(width_px, height_px);
}

void SeamPlaces::link_texels(int width_px, int height_px) {
  Ranks ranks(static_cast<size_t>(width_px) * height_px);
  for (const SeamPlace& place : places)
    for (const auto& side : place.texel)
      for (uint32_t texel : side) ranks.set(texel);
  texels = ranks.count();
  first_read.resize(texels.size() + 1);
  for (SeamPlace& place : places)
    for (auto& side : place.texel)
      for (uint32_t& texel : side) {
        texel = ranks.of(texel);
        ++first_read[texel + 1];
      }
  std::partial_sum(first_read.begin(), first_read.end(), first_read.begin());
  reads.resize(first_read.back());
  std::vector<uint32_t> at(first_read.begin(), first_read.end() - 1);
  for (uint32_t p = 0; p < places.size(); ++p)
    for (const auto& side : places[p].texel)
      for (uint32_t texel : side) reads[at[texel]++] = p;
}

}  // namespace ohb::bake
