// What surfaces see of the lights, found out once for all views: which directions are free at each vertex,
// and what stands in the others. Where a triangle's corners agree, that takes the place of shadow rays; and
// what stands there, of bounces.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "renderer/direction_cells.h"
#include "renderer/eight.h"
#include "renderer/lights.h"
#include "renderer/scene.h"

namespace ohb::renderer {

/// Of each vertex and cell of directions: whether a ray is free. One ray each, in a random direction of the
/// cell and from a random point of the triangles around the vertex, so that shares of bits are shares of
/// area.
class VisibilityCache {
 public:
  explicit VisibilityCache(const Scene& scene);

  /// Rays that it takes to build one.
  static double rays_of(const Scene& scene) {
    return static_cast<double>(scene.positions.size()) * DirectionCells::kCount;
  }

  struct alignas(32) Bits {
    std::array<uint64_t, DirectionCells::kCount / 64> words;
    bool operator[](int cell) const { return words[static_cast<size_t>(cell) / 64] >> (cell % 64) & 1; }
  };
  std::vector<Bits> free;  // one a vertex

  /// What a blocked ray meets, for each kMetStride-th cell: twice the nearest vertex, and 1 if from behind.
  static constexpr int kMetStride = 2, kMet = DirectionCells::kCount / kMetStride;
  static constexpr uint32_t kNothing = 0xffffffffu;
  std::vector<std::array<uint32_t, kMet>> met;
  /// Means around the vertices, 0 where there is no triangle: unit normals, and the share of even light that
  /// is reflected.
  std::vector<Vec3f> normal, reflectance;
};

/// The light that surfaces send to each other in one view, and what a VisibilityCache knows of a triangle.
class LightCache {
 public:
  /// With up to `max_bounces` bounces; those beyond kBounces as a geometric series.
  LightCache(const VisibilityCache& visibility, const Scene& scene, const LightSet& lights, double turn_rad,
             int max_bounces);
  static constexpr int kBounces = 3;

  /// What the corners of a triangle say of the points between them.
  struct Known {
    VisibilityCache::Bits free, maybe;  // at all corners; at one at least
  };
  Known known(const uint32_t* corners) const {
    const auto& bits = visibility_.free;
    const VisibilityCache::Bits &a = bits[corners[0]], &b = bits[corners[1]], &c = bits[corners[2]];
    Known result;
    for (size_t k = 0; k < a.words.size(); ++k) {
      result.free.words[k] = a.words[k] & b.words[k] & c.words[k];
      result.maybe.words[k] = a.words[k] | b.words[k] | c.words[k];
    }
    return result;
  }

  /// Irradiance over pi on one side of a surface that other surfaces cause in the light `l`. `weights` of the
  /// corners add up to 1.
  Vec3f from_surfaces(const uint32_t* corners, const float* weights, bool is_back, size_t l) const {
    Vec3f sum{0, 0, 0};
    for (int k = 0; k < 3; ++k) sum += weights[k] * from_surfaces_[index(corners[k], is_back, l)];
    return sum;
  }
  /// Radiance that leaves one side of a surface in all directions alike, with one bounce less than
  /// from_surfaces(): for those that others see.
  Vec3f leaving(const uint32_t* corners, const float* weights, bool is_back, size_t l) const {
    Float4 sum = 0;
    for (int k = 0; k < 3; ++k) sum += weights[k] * leaving_[index(corners[k], is_back, l)];
    return {sum[0], sum[1], sum[2]};
  }
  /// The share of the cosine-weighted hemisphere on that side where other surfaces are.
  float blocked_share(const uint32_t* corners, const float* weights, bool is_back) const {
    float sum = 0;
    for (int k = 0; k < 3; ++k) sum += weights[k] * blocked_[2 * size_t{corners[k]} + is_back];
    return sum;
  }

 private:
  size_t index(uint32_t vertex, bool is_back, size_t l) const {
    return (2 * size_t{vertex} + is_back) * lights_ + l;
  }
  /// One more bounce: from_surfaces_ and blocked_ from leaving_.
  void gather();
  /// Irradiance by the lights themselves.
  std::vector<Vec3f> direct(const Scene& scene, const LightSet& lights, double turn_rad) const;

  const VisibilityCache& visibility_;
  size_t lights_;
  std::vector<Vec3f> from_surfaces_;
  std::vector<Float4> leaving_;  // radiance, and 0: as wide as the processor adds
  std::vector<float> blocked_;   // 2 x vertex + side
};

}  // namespace ohb::renderer
