// Environment and point lights: lookup, sampling and its pdf.
#pragma once

#include <algorithm>
#include <vector>

#include "dataset/model/sampling.h"
#include "renderer/direction_cells.h"
#include "renderer/render.h"

namespace ohb::renderer {

/// Inverse CDF of a table of non-negative weights with a guide table: monotone in u, so that stratified
/// numbers stay stratified, and O(1) on average (Chen and Asau 1974).
class PiecewiseConstant {
 public:
  PiecewiseConstant() = default;
  explicit PiecewiseConstant(const std::vector<double>& weights);

  /// Index of the cell that u in [0,1) falls in; `rest` is the place in the cell in [0,1).
  int sample(float u, float& rest) const {
    const int n = static_cast<int>(cdf_.size()) - 1;
    int i = guide_[std::min(static_cast<int>(u * static_cast<float>(n)), n - 1)];
    while (i + 1 < n && cdf_[i + 1] <= u) ++i;
    const float width = cdf_[i + 1] - cdf_[i];
    rest = width > 0 ? std::clamp((u - cdf_[i]) / width, 0.0f, 0x1.fffffep-1f) : 0.5f;
    return i;
  }
  float probability(int i) const { return cdf_[i + 1] - cdf_[i]; }
  double total() const { return total_; }

 private:
  std::vector<float> cdf_;  // n + 1, from 0 to 1
  std::vector<int> guide_;  // n: the cell of u = i / n
  double total_ = 0;
};

struct LightSample {
  Vec3f wi;  // unit, world, towards the light
  Vec3f radiance;
  float pdf = 0;  // in solid angle; 0: none
};

/// Where latitude-longitude maps hold a direction: one place for all lights.
struct MapPlace {
  Vec2f uv;
  float sin_theta;  // of the polar angle
};
MapPlace map_place(Vec3f direction);

/// What an environment sends from one direction, and how likely `sample` goes there (in solid angle).
struct EnvironmentValue {
  Vec3f radiance;
  float pdf = 0;
};

/// A latitude-longitude map, bilinear as Cycles looks it up. Sampled exactly by the bilinear function of mean
/// RGB (times the sine of each row): a bilinear map is a sum of tents, one a texel, so a texel is drawn from
/// a table and a place in its tent by the tent's inverse.
class EnvironmentLight {
 public:
  explicit EnvironmentLight(const Environment& environment);

  /// Radiance and pdf of a unit direction, world frame: one gather of four texels.
  EnvironmentValue at(Vec3f direction) const { return at(map_place(direction)); }
  EnvironmentValue at(MapPlace place) const;
  /// Brings what `at` will read into the cache.
  void prefetch(MapPlace place) const;
  LightSample sample(float u1, float u2) const;
  const std::string& name() const { return name_; }

 private:
  struct alignas(16) Texel {
    Vec3f radiance;
    float density;  // of `sample` in solid angle, times the sine of the direction's polar angle
  };
  /// The four texels around a place, and how far it is from the first along each axis.
  struct Gather {
    const Texel *row0, *row1;
    int x0, x1;
    float fx, fy;
  };
  Gather gather(Vec2f uv) const;
  std::string name_;
  int width_px_, height_px_;
  std::vector<Texel> texels_;
  PiecewiseConstant rows_;
  std::vector<PiecewiseConstant> columns_;  // one a row
};

/// Eight directions that an environment suggests, in the subject's frame: they spread over the light.
struct alignas(32) LightCandidates {
  static constexpr int kCount = 8;
  float wi_x[kCount], wi_y[kCount], wi_z[kCount];
  float red[kCount], green[kCount], blue[kCount];
  float pdf[kCount];     // in solid angle; 0: none
  uint8_t cell[kCount];  // of DirectionCells, or 0

  void set(int k, Vec3f wi, Vec3f radiance, float pdf_of_wi, int cell_of_wi) {
    wi_x[k] = wi.x, wi_y[k] = wi.y, wi_z[k] = wi.z;
    red[k] = radiance.x, green[k] = radiance.y, blue[k] = radiance.z;
    pdf[k] = pdf_of_wi;
    cell[k] = static_cast<uint8_t>(cell_of_wi);
  }
};

/// Directions of an environment drawn in advance, one in each cell of a grid over [0, 1)^2, for many paths to
/// choose from: a lookup in the cache instead of many in the map. Whoever chooses a group evenly and without
/// looking gets directions of density pdf, so that each path's estimate stays unbiased; paths that share a
/// pool are correlated.
class LightPool {
 public:
  /// A grid of 2^columns_log2 (at least 8) x 2^rows_log2; `turn_rad` turns the subject. `cell` of the
  /// candidates is set if asked for. A function of its arguments.
  void fill(const EnvironmentLight& light, double turn_rad, int columns_log2, int rows_log2, uint64_t key,
            bool with_cells);
  /// The group that u in [0, 1)^2 falls in.
  const LightCandidates& at(Vec2f u) const {
    const int x = static_cast<int>(u.x * static_cast<float>(columns_)),
              y = static_cast<int>(u.y * static_cast<float>(rows_));
    return groups_[static_cast<size_t>(y * columns_ + x)];
  }
  const std::vector<LightCandidates>& groups() const { return groups_; }

 private:
  std::vector<LightCandidates> groups_;
  int columns_ = 0, rows_ = 0;  // of groups
};

class LightSet {
 public:
  std::vector<EnvironmentLight> environments;
  std::vector<PointLight> points;
  size_t size() const { return environments.size() + points.size(); }
};

}  // namespace ohb::renderer
