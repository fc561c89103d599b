// Rays and nearest points against triangles, for fitting, hiding and checking.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "dataset/model/vec.h"
#include "dataset/surface/triangle_tree.h"

namespace ohb::people {

struct SurfaceTriangle {
  uint32_t corner[3];
  uint32_t face = 0;  // whatever the caller counts
};

struct SurfaceHit {
  bool found = false;
  uint32_t triangle = 0;
  float u = 0, v = 0;  // barycentric weights of corners 1 and 2
  float distance_cm = 0;
  Vec3f normal;  // unit, by the triangle's winding
};

/// Triangles over a copy of the positions. Queries may run in several threads.
class SurfaceQuery {
 public:
  SurfaceQuery(std::vector<Vec3f> positions_cm, std::vector<SurfaceTriangle> triangles);
  SurfaceQuery(SurfaceQuery&&) = default;
  SurfaceQuery(const SurfaceQuery&) = delete;

  /// The first triangle along a unit direction within `reach_cm`.
  SurfaceHit first_hit(Vec3f origin, Vec3f direction, float reach_cm) const;
  bool is_blocked(Vec3f origin, Vec3f direction, float reach_cm) const;
  /// The nearest point within `reach_cm` on triangles that `counts(triangle)` accepts.
  SurfaceHit nearest(Vec3f point, float reach_cm,
                     const std::function<bool(uint32_t)>& counts = nullptr) const;

  bool is_empty() const { return triangles_.empty(); }
  const std::vector<SurfaceTriangle>& triangles() const { return triangles_; }
  Vec3f normal(uint32_t triangle) const;
  Vec3f at(const SurfaceHit& hit) const;

 private:
  std::vector<Vec3f> positions_;  // one more than there are
  std::vector<SurfaceTriangle> triangles_;
  std::vector<uint32_t> corners_;  // as the tree reads them
  surface::TriangleTree tree_;
};

/// Nearest point of a triangle (Ericson 2005, Real-Time Collision Detection, 5.1.5) as weights of b and c.
void nearest_in_triangle(Vec3f p, Vec3f a, Vec3f b, Vec3f c, float& v, float& w);

}  // namespace ohb::people
