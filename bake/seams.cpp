#include "bake/seams.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "dataset/model/colour.h"

namespace ohb::bake {
namespace {

struct EdgeUse {
  uint32_t low, high;  // positions
  uint32_t triangle;   // of the model
  uint8_t corner;      // the edge goes from it to the next
  bool operator<(const EdgeUse& other) const {
    if (low != other.low) return low < other.low;
    if (high != other.high) return high < other.high;
    if (triangle != other.triangle) return triangle < other.triangle;
    return corner < other.corner;
  }
};

SeamSide side_of(const Model& model, const EdgeUse& use, const MeshFrames* frames) {
  const ModelTriangle& triangle = model.triangles[use.triangle];
  SeamSide side;
  int corners[2] = {use.corner, (use.corner + 1) % 3};
  if (triangle.position[corners[0]] != use.low) std::swap(corners[0], corners[1]);
  side.apex = model.uvs[triangle.uv[(use.corner + 2) % 3]];
  for (int end = 0; end < 2; ++end) {
    side.uv[end] = model.uvs[triangle.uv[corners[end]]];
    if (!frames) continue;
    const CornerTangent& corner = frames->tangents[3 * size_t{use.triangle} + corners[end]];
    side.tangent[end] = corner.tangent;
    side.normal[end] = frames->normals[triangle.position[corners[end]]];
    side.sign = corner.sign;
  }
  return side;
}

bool is_same(Vec2f a, Vec2f b) {
  return a.x == b.x && a.y == b.y;
}

int wrapped(int i, int size) {
  if (i >= 0 && i < size) return i;
  const int rest = i % size;
  return rest < 0 ? rest + size : rest;
}

/// The blocks of one mip level, of which only those are made that the lookups at seams read, or blocks of a
/// coarser level that they read.
struct SparseLevel {
  int width_px, height_px, channels;
  std::vector<uint8_t> is_read;
  std::unique_ptr<float[]> made;  // none at level 0, which is the map
  const float* values;

  SparseLevel(const Image& map, int level)
      : width_px((map.width_px + (1 << level) - 1) >> level),
        height_px((map.height_px + (1 << level) - 1) >> level),
        channels(map.channels) {
    if (level > 0) is_read.resize(static_cast<size_t>(width_px) * height_px);
    if (level > 0) made.reset(new float[is_read.size() * channels]);
    values = level > 0 ? made.get() : map.values.data();
  }
  const float* pixel(int x, int y) const {
    return &values[(static_cast<size_t>(y) * width_px + x) * channels];
  }

  void mark_blocks_of(const SparseLevel& coarser) {
    tbb::parallel_for(0, height_px, [&](int y) {
      for (int x = 0; x < width_px; ++x)
        is_read[static_cast<size_t>(y) * width_px + x] |=
            coarser.is_read[static_cast<size_t>(y / 2) * coarser.width_px + x / 2];
    });
  }

  /// Each block is the mean of its 2 x 2 finer ones (fewer at odd borders).
  void halve(const SparseLevel& finer) {
    tbb::parallel_for(0, height_px, [&](int y) {
      for (int x = 0; x < width_px; ++x) {
        const size_t block = static_cast<size_t>(y) * width_px + x;
        if (!is_read[block]) continue;
        float* const out = &made[block * channels];
        std::fill(out, out + channels, 0.0f);
        int count = 0;
        for (int sy = 2 * y; sy < std::min(2 * y + 2, finer.height_px); ++sy)
          for (int sx = 2 * x; sx < std::min(2 * x + 2, finer.width_px); ++sx, ++count)
            for (int c = 0; c < channels; ++c) out[c] += finer.pixel(sx, sy)[c];
        for (int c = 0; c < channels; ++c) out[c] /= static_cast<float>(count);
      }
    });
  }
};

float along_of(int point) {
  return (static_cast<float>(point) + 0.5f) / kSeamPoints;
}

/// The first `count` mip levels of a map where lookups at seams read them.
std::vector<SparseLevel> levels_at_seams(const Image& map, const std::vector<Seam>& seams, int count) {
  std::vector<SparseLevel> levels;
  levels.reserve(count);
  for (int l = 0; l < count; ++l) levels.emplace_back(map, l);
  tbb::parallel_for(1, std::max(1, count), [&](int l) {
    for (const Seam& seam : seams)
      for (const SeamSide& side : seam.side)
        for (int i = 0; i < kSeamPoints; ++i) {
          const SeamLookup lookup = lookup_at(side, along_of(i), l, map.width_px, map.height_px);
          for (int row : lookup.row)
            for (int column : lookup.column)
              levels[l].is_read[static_cast<size_t>(row) * levels[l].width_px + column] = 1;
        }
  });
  for (int l = count - 1; l > 1; --l) levels[l - 1].mark_blocks_of(levels[l]);
  for (int l = 1; l < count; ++l) levels[l].halve(levels[l - 1]);
  return levels;
}

Vec3f value_at(const SparseLevel& level, const SeamLookup& lookup) {
  Vec3f value;
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 2; ++i)
      for (int c = 0; c < level.channels; ++c)
        value[c] += lookup.weight[j][i] * level.pixel(lookup.column[i], lookup.row[j])[c];
  return value;
}

double difference(Vec3f a, Vec3f b, const Seam& seam, float along, int channels, MapValues values) {
  if (values == MapValues::kNormals) {
    const SeamFrame f = frame_at(seam.side[0], along), g = frame_at(seam.side[1], along);
    const Vec3f m = to_model(f, a), n = to_model(g, b);
    return std::atan2(length(cross(m, n)), dot(m, n)) * 180 / 3.14159265358979;
  }
  double worst = 0;
  for (int c = 0; c < channels; ++c) {
    const bool is_colour = values == MapValues::kLinearColour;
    const float p = is_colour ? linear_to_srgb(a[c]) : a[c], q = is_colour ? linear_to_srgb(b[c]) : b[c];
    worst = std::max(worst, static_cast<double>(std::fabs(p - q)));
  }
  return worst;
}

SeamError error_of(std::vector<float>& differences, double limit) {
  SeamError error;
  if (differences.empty()) return error;
  std::sort(differences.begin(), differences.end());
  double sum = 0;
  for (float d : differences) sum += d;
  const size_t count = differences.size();
  error.mean = sum / static_cast<double>(count);
  error.percentile_99 = differences[std::min(count - 1, count * 99 / 100)];
  error.max = differences.back();
  const auto above = std::upper_bound(differences.begin(), differences.end(), static_cast<float>(limit));
  error.share_above = static_cast<double>(differences.end() - above) / static_cast<double>(count);
  return error;
}

}  // namespace

MeshFrames frames_of(const Model& model) {
  MeshFrames frames;
  frames.normals = smooth_normals(model);
  frames.tangents = mikktspace_tangents(model, frames.normals);
  return frames;
}

std::vector<Seam> find_seams(const Model& model, const std::vector<uint32_t>& triangles,
                             const MeshFrames* frames) {
  std::vector<EdgeUse> uses;
  uses.reserve(3 * triangles.size());
  for (uint32_t t : triangles)
    for (uint8_t c = 0; c < 3; ++c) {
      const uint32_t a = model.triangles[t].position[c], b = model.triangles[t].position[(c + 1) % 3];
      if (a != b) uses.push_back({std::min(a, b), std::max(a, b), t, c});
    }
  std::sort(uses.begin(), uses.end());
  std::vector<Seam> seams;
  for (size_t first = 0; first < uses.size();) {
    size_t next = first + 1;
    for (; next < uses.size() && uses[next].low == uses[first].low && uses[next].high == uses[first].high;
         ++next) {
      Seam seam{{side_of(model, uses[first], frames), side_of(model, uses[next], frames)}};
      const SeamSide &a = seam.side[0], &b = seam.side[1];
      if (!is_same(a.uv[0], b.uv[0]) || !is_same(a.uv[1], b.uv[1])) seams.push_back(seam);
    }
    first = next;
  }
  return seams;
}

SeamLookup lookup_at(const SeamSide& side, float along, int level, int width_px, int height_px) {
  const double u = (1.0 - along) * side.uv[0].x + double(along) * side.uv[1].x;
  const double v = (1.0 - along) * side.uv[0].y + double(along) * side.uv[1].y;
  const double scale = 1.0 / (1 << level);
  const double x = (u - std::floor(u)) * width_px * scale - 0.5;
  const double y = (1 - (v - std::floor(v))) * height_px * scale - 0.5;
  const double x_whole = std::floor(x), y_whole = std::floor(y);
  const float fx = static_cast<float>(x - x_whole), fy = static_cast<float>(y - y_whole);
  const int block = 1 << level;
  const int columns = (width_px + block - 1) / block, rows = (height_px + block - 1) / block;
  SeamLookup lookup;
  for (int i = 0; i < 2; ++i) {
    lookup.column[i] = wrapped(static_cast<int>(x_whole) + i, columns);
    lookup.row[i] = wrapped(static_cast<int>(y_whole) + i, rows);
  }
  const float wx[2] = {1 - fx, fx}, wy[2] = {1 - fy, fy};
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 2; ++i) lookup.weight[j][i] = wy[j] * wx[i];
  return lookup;
}

SeamFrame frame_at(const SeamSide& side, float along) {
  const Vec3f t = (1 - along) * side.tangent[0] + along * side.tangent[1];
  const Vec3f n = (1 - along) * side.normal[0] + along * side.normal[1];
  return {t, side.sign * cross(n, t), n};
}

std::vector<SeamError> seam_errors(const Image& map, const std::vector<Seam>& seams, MapValues values,
                                   int levels) {
  std::vector<SeamError> errors;
  std::vector<float> differences(seams.size() * kSeamPoints);
  const std::vector<SparseLevel> made = levels_at_seams(map, seams, levels);
  for (int level = 0; level < levels; ++level) {
    tbb::parallel_for(size_t{0}, seams.size(), [&](size_t s) {
      for (int i = 0; i < kSeamPoints; ++i) {
        const float along = along_of(i);
        Vec3f value[2];
        for (int k = 0; k < 2; ++k)
          value[k] =
              value_at(made[level], lookup_at(seams[s].side[k], along, level, map.width_px, map.height_px));
        differences[s * kSeamPoints + i] =
            static_cast<float>(difference(value[0], value[1], seams[s], along, map.channels, values));
      }
    });
    std::vector<float> sorted = differences;
    errors.push_back(error_of(sorted, values == MapValues::kNormals ? 1.0 : 1.0 / 255));
  }
  return errors;
}

}  // namespace ohb::bake
