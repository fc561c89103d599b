#include "bake/seam_mend.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "dataset/model/colour.h"

namespace ohb {
namespace {

/// How much a texel inside a triangle gives way, of what one of the background does.
constexpr float kInsideGive[kMendLevels] = {0.1f, 0};

/// Where few of the texels give way they are not moved all the way: a share of what all of them would take.
constexpr float kDamping = 0.1f;
constexpr int kFullSweepEvery = 6;

class Mend {
 public:
  Mend(Image& map, const std::vector<Seam>& seams, const std::vector<uint8_t>& is_inside, MapValues values,
       float tolerance)
      : map_(map), seams_(seams), is_inside_(is_inside), values_(values), tolerance_(tolerance) {}

  float most_changed() const {
    float most = 0;
    for (const auto& [texel, value] : before_)
      for (int c = 0; c < map_.channels; ++c)
        most = std::max(most, std::fabs(map_.values[texel * map_.channels + c] - value[c]));
    return most;
  }

  void run() {
    std::vector<uint8_t> has_moved(seams_.size(), 1);
    for (int sweep = 0; sweep < kMendSweeps; ++sweep) {
      // Edges that agreed are looked at again only now and then: their neighbours may have moved them.
      const bool is_full = sweep % kFullSweepEvery == 0;
      size_t moved = 0;
      for (size_t s = 0; s < seams_.size(); ++s) {
        if (!is_full && !has_moved[s]) continue;
        size_t of_edge = 0;
        for (int level = kMendLevels; level-- > 0;) of_edge += mend_edge(seams_[s], level);
        has_moved[s] = of_edge > 0;
        moved += of_edge;
      }
      if (is_full && moved == 0) break;
    }
  }

 private:
  /// As many lookups as the edge crosses half blocks of the level.
  size_t mend_edge(const Seam& seam, int level) {
    float longer = 0;
    for (const SeamSide& side : seam.side) {
      const Vec2f edge = side.uv[1] - side.uv[0];
      const Vec2f px{edge.x * static_cast<float>(map_.width_px), edge.y * static_cast<float>(map_.height_px)};
      longer = std::max(longer, std::sqrt(dot(px, px)));
    }
    const int lookups =
        std::clamp(static_cast<int>(std::ceil(2 * longer / static_cast<float>(1 << level))), 1, kSeamPoints);
    size_t moved = 0;
    for (int i = 0; i < lookups; ++i)
      moved += mend_place(seam, (static_cast<float>(i) + 0.5f) / static_cast<float>(lookups), level);
    return moved;
  }

  struct Read {
    SeamLookup lookup;
    Vec3f value;
    float give = 0, all = 0;  // sums over the texels of squared weight, times give and without
  };

  Read read(const SeamSide& side, float along, int level) const {
    Read read{lookup_at(side, along, level, map_.width_px, map_.height_px), {}, 0, 0};
    for_each_texel(read.lookup, level, [&](size_t texel, float weight) {
      for (int c = 0; c < map_.channels; ++c)
        read.value[c] += weight * map_.values[texel * map_.channels + c];
      read.give += weight * weight * give(texel, level);
      read.all += weight * weight;
    });
    return read;
  }

  float give(size_t texel, int level) const { return is_inside_[texel] ? kInsideGive[level] : 1.0f; }

  template <typename Visit>
  void for_each_texel(const SeamLookup& lookup, int level, const Visit& visit) const {
    const int block = 1 << level;
    for (int j = 0; j < 2; ++j)
      for (int i = 0; i < 2; ++i) {
        const int low_x = lookup.column[i] * block, low_y = lookup.row[j] * block;
        const int high_x = std::min(low_x + block, map_.width_px),
                  high_y = std::min(low_y + block, map_.height_px);
        const float weight = lookup.weight[j][i] / static_cast<float>((high_x - low_x) * (high_y - low_y));
        if (weight == 0) continue;
        for (int y = low_y; y < high_y; ++y)
          for (int x = low_x; x < high_x; ++x) visit(static_cast<size_t>(y) * map_.width_px + x, weight);
      }
  }

  bool mend_place(const Seam& seam, float along, int level) {
    const Read a = read(seam.side[0], along, level), b = read(seam.side[1], along, level);
    if (!(a.give + b.give > 0)) return false;
    const float give = a.give + b.give + kDamping * (a.all + b.all);
    if (values_ != MapValues::kNormals) {
      const Vec3f apart = a.value - b.value, seen = as_seen(a.value) - as_seen(b.value);
      if (std::max({std::fabs(seen.x), std::fabs(seen.y), std::fabs(seen.z)}) <= tolerance_) return false;
      move(a, level, -apart / give);
      move(b, level, apart / give);
      return true;
    }
    // In the model's frame; the frames are close to orthonormal, so their transposes carry the change back.
    const SeamFrame f = frame_at(seam.side[0], along), g = frame_at(seam.side[1], along);
    const auto to_model = [](const SeamFrame& frame, Vec3f v) {
      return v.x * frame.tangent + v.y * frame.bitangent + v.z * frame.normal;
    };
    const auto to_frame = [](const SeamFrame& frame, Vec3f v) {
      return Vec3f{dot(v, frame.tangent), dot(v, frame.bitangent), dot(v, frame.normal)};
    };
    const Vec3f apart = to_model(f, a.value) - to_model(g, b.value);
    if (length(apart) <= tolerance_) return false;
    move(a, level, to_frame(f, -apart) / give);
    move(b, level, to_frame(g, apart) / give);
    return true;
  }

  Vec3f as_seen(Vec3f value) const {
    if (values_ != MapValues::kLinearColour) return value;
    return {linear_to_srgb(value.x), linear_to_srgb(value.y), linear_to_srgb(value.z)};
  }

  void move(const Read& read, int level, Vec3f step) {
    for_each_texel(read.lookup, level, [&](size_t texel, float weight) {
      const float share = weight * give(texel, level);
      if (share == 0) return;
      float* const value = &map_.values[texel * map_.channels];
      if (is_inside_[texel])
        before_.emplace(texel,
                        Vec3f{value[0], map_.channels > 1 ? value[1] : 0, map_.channels > 2 ? value[2] : 0});
      for (int c = 0; c < map_.channels; ++c) value[c] += share * step[c];
      if (values_ == MapValues::kNormals) {
        const Vec3f unit = normalised({value[0], value[1], value[2]});
        for (int c = 0; c < 3; ++c) value[c] = unit[c];
      } else {
        for (int c = 0; c < map_.channels; ++c) value[c] = std::clamp(value[c], 0.0f, 1.0f);
      }
    });
  }

  Image& map_;
  const std::vector<Seam>& seams_;
  const std::vector<uint8_t>& is_inside_;
  const MapValues values_;
  const float tolerance_;
  std::unordered_map<size_t, Vec3f> before_;  // texels inside triangles that were moved
};

}  // namespace

float mend_seams(Image& map, const std::vector<Seam>& seams, const std::vector<uint8_t>& is_inside,
                 MapValues values, float tolerance) {
  Mend mend(map, seams, is_inside, values, tolerance);
  mend.run();
  return mend.most_changed();
}

}  // namespace ohb
