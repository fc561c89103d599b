#include "bake/seam_mend.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "dataset/model/colour.h"

namespace ohb::bake {
namespace {

/// How much a texel inside a triangle gives way at level 0, of what one of the background does.
constexpr float kInsideGive = 0.1f;

/// Where few of the texels give way they are not moved all the way: a share of what all of them would take.
constexpr float kDamping = 0.1f;
constexpr int kFullSweepEvery = 6;

/// The frames are close to orthonormal, so their transposes carry a change back.
Vec3f to_frame(const SeamFrame& frame, Vec3f v) {
  return {dot(v, frame.tangent), dot(v, frame.bitangent), dot(v, frame.normal)};
}

Vec3f as_seen(Vec3f value, MapValues values) {
  if (values != MapValues::kLinearColour) return value;
  return {linear_to_srgb(value.x), linear_to_srgb(value.y), linear_to_srgb(value.z)};
}

/// What a texel may hold.
Vec3f fitted(Vec3f value, MapValues values) {
  if (values == MapValues::kNormals) return normalised(value);
  for (int c = 0; c < 3; ++c) value[c] = std::clamp(value[c], 0.0f, 1.0f);
  return value;
}

}  // namespace

template <typename Visit>
void SeamMender::for_each_texel(const Block& block, const Visit& visit) const {
  const int size = 1 << block.level, columns = columns_of(block.level);
  const int low_x = static_cast<int>(block.index % columns) * size;
  const int low_y = static_cast<int>(block.index / columns) * size;
  const int high_x = std::min(low_x + size, width_px_), high_y = std::min(low_y + size, height_px_);
  for (int y = low_y; y < high_y; ++y)
    for (int x = low_x; x < high_x; ++x) visit(static_cast<size_t>(y) * width_px_ + x);
}

/// With the blocks' indices in their level.
std::vector<SeamMender::Place> SeamMender::places_of(uint32_t seam, int level) const {
  float longer_px = 0;
  for (const SeamSide& side : seams_[seam].side) {
    const Vec2f edge = side.uv[1] - side.uv[0];
    const Vec2f px{edge.x * static_cast<float>(width_px_), edge.y * static_cast<float>(height_px_)};
    longer_px = std::max(longer_px, std::sqrt(dot(px, px)));
  }
  const int count = std::max(1, static_cast<int>(std::ceil(2 * longer_px / static_cast<float>(1 << level))));
  std::vector<Place> places(count);
  for (int i = 0; i < count; ++i) {
    Place& place = places[i];
    place.along = (static_cast<float>(i) + 0.5f) / static_cast<float>(count);
    for (int k = 0; k < 2; ++k) {
      const SeamLookup lookup = lookup_at(seams_[seam].side[k], place.along, level, width_px_, height_px_);
      for (int j = 0; j < 4; ++j) {
        place.block[k][j] =
            static_cast<uint32_t>(lookup.row[j / 2] * columns_of(level) + lookup.column[j % 2]);
        place.weight[k][j] = lookup.weight[j / 2][j % 2];
      }
    }
  }
  return places;
}

void SeamMender::collect_places() {
  for (uint32_t s = 0; s < seams_.size(); ++s) {
    place_begin_.push_back(places_.size());
    for (int level = levels_; level-- > 0;) {
      const std::vector<Place> places = places_of(s, level);
      places_.insert(places_.end(), places.begin(), places.end());
      place_level_.resize(places_.size(), static_cast<uint8_t>(level));
    }
  }
  place_begin_.push_back(places_.size());
}

/// Gives each block that is read a place of its own in blocks_, and says so in places_.
void SeamMender::link_blocks() {
  std::vector<uint32_t> indices[kMostLevels];
  uint32_t first_block[kMostLevels] = {};
  for (size_t p = 0; p < places_.size(); ++p)
    for (const auto& side : places_[p].block)
      for (uint32_t index : side) indices[place_level_[p]].push_back(index);
  for (int l = 0; l < levels_; ++l) {
    std::sort(indices[l].begin(), indices[l].end());
    indices[l].erase(std::unique(indices[l].begin(), indices[l].end()), indices[l].end());
    first_block[l] = static_cast<uint32_t>(blocks_.size());
    for (uint32_t index : indices[l]) {
      blocks_.emplace_back();
      blocks_.back().index = index;
      blocks_.back().level = static_cast<uint8_t>(l);
    }
    if (l == 0) texels_end_ = blocks_.size();
  }
  const auto find = [&](int level, uint32_t index) {
    const auto found = std::lower_bound(indices[level].begin(), indices[level].end(), index);
    if (found == indices[level].end() || *found != index) return kNone;
    return first_block[level] + static_cast<uint32_t>(found - indices[level].begin());
  };
  tbb::parallel_for(size_t{0}, blocks_.size(), [&](size_t b) {
    Block& block = blocks_[b];
    const int coarser = block.level + 1;
    const uint32_t x = block.index % columns_of(block.level), y = block.index / columns_of(block.level);
    block.part_of = coarser < levels_ ? find(coarser, (y / 2) * columns_of(coarser) + x / 2) : kNone;
  });
  tbb::parallel_for(size_t{0}, places_.size(), [&](size_t p) {
    for (auto& side : places_[p].block)
      for (uint32_t& block : side) block = find(place_level_[p], block);
  });
}

/// Places read their blocks again and again: blocks of one seam lie beside each other in memory.
void SeamMender::order_blocks() {
  std::vector<uint32_t> place_of(blocks_.size(), kNone);
  std::vector<Block> ordered;
  ordered.reserve(blocks_.size());
  for (int level = 0; level < levels_; ++level)
    for (size_t p = 0; p < places_.size(); ++p) {
      if (place_level_[p] != level) continue;
      for (const auto& side : places_[p].block)
        for (uint32_t block : side) {
          if (place_of[block] != kNone) continue;
          place_of[block] = static_cast<uint32_t>(ordered.size());
          ordered.push_back(blocks_[block]);
        }
    }
  blocks_ = std::move(ordered);
  for (Block& block : blocks_)
    if (block.part_of != kNone) block.part_of = place_of[block.part_of];
  for (Place& place : places_)
    for (auto& side : place.block)
      for (uint32_t& block : side) block = place_of[block];
}

SeamMender::SeamMender(const std::vector<Seam>& seams, const std::vector<uint8_t>& is_inside, int width_px,
                       int height_px, int levels)
    : seams_(seams), is_inside_(is_inside), width_px_(width_px), height_px_(height_px), levels_(levels) {
  collect_places();
  link_blocks();
  order_blocks();
  tbb::parallel_for(size_t{0}, blocks_.size(), [&](size_t b) {
    Block& block = blocks_[b];
    int background = 0, count = 0;
    for_each_texel(block, [&](size_t texel) {
      background += !is_inside_[texel];
      ++count;
    });
    block.background = static_cast<float>(background) / static_cast<float>(count);
    block.give = block.level == 0 && background == 0 ? kInsideGive : block.background;
  });
  for (Place& place : places_) {
    float give = 0, all = 0;
    for (int k = 0; k < 2; ++k)
      for (int j = 0; j < 4; ++j) {
        const float squared = place.weight[k][j] * place.weight[k][j];
        give += squared * blocks_[place.block[k][j]].give;
        all += squared;
      }
    place.step = give > 0 ? 1 / (give + kDamping * all) : 0;
  }
}

/// One map in the making.
class SeamMender::Solver {
 public:
  Solver(const SeamMender& mender, Image& map, MapValues values, float tolerance)
      : mender_(mender), map_(map), values_(values), tolerance_(tolerance) {}

  void solve() {
    gather();
    std::vector<uint8_t> has_moved(mender_.seams_.size(), 1);
    for (int sweep = 0; sweep < kMendSweeps; ++sweep) {
      // Edges that agreed are looked at again only now and then: their neighbours may have moved them.
      const bool is_full = sweep % kFullSweepEvery == 0;
      size_t moved = 0;
      for (size_t s = 0; s < mender_.seams_.size(); ++s) {
        if (!is_full && !has_moved[s]) continue;
        size_t of_edge = 0;
        for (size_t p = mender_.place_begin_[s]; p < mender_.place_begin_[s + 1]; ++p)
          of_edge += mend_place(mender_.seams_[s], mender_.places_[p]);
        has_moved[s] = of_edge > 0;
        moved += of_edge;
      }
      if (is_full && moved == 0) break;
    }
    scatter();
  }

  std::vector<Vec3f> texels() const {
    std::vector<Vec3f> values(mender_.texels_end_);
    for (size_t b = 0; b < values.size(); ++b) values[b] = texel(mender_.blocks_[b].index);
    return values;
  }

 private:
  /// What the sweeps read and change of a block, in one line of the cache.
  struct alignas(64) State {
    Vec3f mean;   // but for what the block that it is part of was moved by
    Vec3f shift;  // of its background; of a texel: of the texel
    float background, give;
    uint32_t part_of;
    bool is_texel;
  };

  Vec3f texel(size_t index) const {
    const float* const v = &map_.values[index * map_.channels];
    return {v[0], map_.channels > 1 ? v[1] : 0, map_.channels > 2 ? v[2] : 0};
  }

  void add(size_t index, Vec3f change) {
    for (int c = 0; c < map_.channels; ++c) map_.values[index * map_.channels + c] += change[c];
  }

  void gather() {
    state_.resize(mender_.blocks_.size());
    tbb::parallel_for(size_t{0}, state_.size(), [&](size_t b) {
      const Block& block = mender_.blocks_[b];
      Vec3f sum;
      int count = 0;
      mender_.for_each_texel(block, [&](size_t index) {
        sum += texel(index);
        ++count;
      });
      state_[b] = {
          sum / static_cast<float>(count), {}, block.background, block.give, block.part_of, block.level == 0};
    });
  }

  /// Coarse levels change the background of their blocks, level 0 each texel.
  void scatter() {
    for (size_t b = mender_.texels_end_; b < state_.size(); ++b) {
      const Vec3f shift = state_[b].shift;
      if (shift.x == 0 && shift.y == 0 && shift.z == 0) continue;
      mender_.for_each_texel(mender_.blocks_[b], [&](size_t index) {
        if (!mender_.is_inside_[index]) add(index, shift);
      });
    }
    for (size_t b = 0; b < mender_.texels_end_; ++b) add(mender_.blocks_[b].index, state_[b].shift);
    const auto fit = [&](size_t index) {
      const Vec3f value = fitted(texel(index), values_);
      for (int c = 0; c < map_.channels; ++c) map_.values[index * map_.channels + c] = value[c];
    };
    for (size_t b = 0; b < state_.size(); ++b)
      if (state_[b].shift.x != 0 || state_[b].shift.y != 0 || state_[b].shift.z != 0)
        mender_.for_each_texel(mender_.blocks_[b], fit);
  }

  Vec3f value_of(const State& block) const {
    if (block.part_of == kNone) return block.mean;
    return block.mean + block.background * state_[block.part_of].shift;
  }

  Vec3f read(const Place& place, int side) const {
    Vec3f value;
    for (int j = 0; j < 4; ++j) value += place.weight[side][j] * value_of(state_[place.block[side][j]]);
    return value;
  }

  /// Whether colours look the same. Encoding them is dear: where the bounds of the encoding's slope within
  /// [0,1], 12.92 and 0.4396, leave no doubt, they are not.
  bool agree(Vec3f a, Vec3f b) const {
    if (values_ == MapValues::kLinearColour) {
      constexpr float kRounding = 1e-5f;
      float most = 0, brightest = 0;
      for (int c = 0; c < 3; ++c) {
        most = std::max(most, std::fabs(a[c] - b[c]));
        brightest = std::max({brightest, a[c], b[c]});
      }
      if (12.92f * most + kRounding <= tolerance_) return true;
      if (brightest <= 1 && 0.43f * most > tolerance_ + kRounding) return false;
    }
    const Vec3f apart = as_seen(a, values_) - as_seen(b, values_);
    return std::max({std::fabs(apart.x), std::fabs(apart.y), std::fabs(apart.z)}) <= tolerance_;
  }

  bool mend_place(const Seam& seam, const Place& place) {
    if (place.step == 0) return false;
    const Vec3f a = read(place, 0), b = read(place, 1);
    if (values_ != MapValues::kNormals) {
      if (agree(a, b)) return false;
      move(place, 0, place.step * (b - a));
      move(place, 1, place.step * (a - b));
      return true;
    }
    // Only their directions in the model's frame need agree, not how long averages of them have become.
    const SeamFrame f = frame_at(seam.side[0], place.along), g = frame_at(seam.side[1], place.along);
    const Vec3f m = to_model(f, a), n = to_model(g, b), middle = normalised(m + n);
    const Vec3f apart = (m - n) - dot(m - n, middle) * middle;
    if (dot(apart, apart) <= tolerance_ * tolerance_ * std::max(dot(m, m), dot(n, n))) return false;
    move(place, 0, to_frame(f, -place.step * apart));
    move(place, 1, to_frame(g, place.step * apart));
    return true;
  }

  void move(const Place& place, int side, Vec3f step) {
    for (int j = 0; j < 4; ++j) {
      State& block = state_[place.block[side][j]];
      if (block.give == 0) continue;
      Vec3f change = place.weight[side][j] * block.give * step;
      if (block.is_texel) {
        const Vec3f value = value_of(block);
        change = fitted(value + change, values_) - value;
      }
      block.mean += change;
      block.shift += block.is_texel ? change : change / block.background;
      if (block.part_of != kNone) state_[block.part_of].mean += 0.25f * change;
    }
  }

  const SeamMender& mender_;
  Image& map_;
  const MapValues values_;
  const float tolerance_;
  std::vector<State> state_;  // of the blocks
};

float SeamMender::mend(Image& map, MapValues values, float tolerance) const {
  Solver solver(*this, map, values, tolerance);
  const std::vector<Vec3f> before = solver.texels();
  for (int round = 0; round < kMendRounds; ++round) solver.solve();
  const std::vector<Vec3f> after = solver.texels();
  float most = 0;
  for (size_t b = 0; b < before.size(); ++b)
    if (is_inside_[blocks_[b].index])
      for (int c = 0; c < 3; ++c) most = std::max(most, std::fabs(after[b][c] - before[b][c]));
  return most;
}

}  // namespace ohb::bake
