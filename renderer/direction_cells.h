// The sphere of directions in squares: the octahedron's map (Meyer et al., "On Floating-Point Normal
// Vectors", 2010, section 3.2), folded along the plane y = 0.
#pragma once

#include <algorithm>
#include <cmath>

#include "dataset/model/vec.h"

namespace ohb::renderer {

struct DirectionCells {
  static constexpr int kSide = 16, kCount = kSide * kSide;

  /// The cell of a direction (not 0, of any length).
  static int cell_of(Vec3f d) {
    const float scale = 1 / (std::fabs(d.x) + std::fabs(d.y) + std::fabs(d.z));
    const Vec2f p = folded({d.x * scale, d.z * scale}, d.y);
    return index(p.y) * kSide + index(p.x);
  }
  /// The unit direction at (u, v) in [0, 1]^2 of a cell.
  static Vec3f direction(int cell, float u, float v) {
    const Vec2f p{2 * (static_cast<float>(cell % kSide) + u) / kSide - 1,
                  2 * (static_cast<float>(cell / kSide) + v) / kSide - 1};
    const float y = 1 - std::fabs(p.x) - std::fabs(p.y);
    const Vec2f q = folded(p, y);
    const Vec3f d{q.x, y, q.y};
    return d / std::sqrt(dot(d, d));
  }

 private:
  /// The lower half's four triangles lie outside the square |x| + |z| = 1. Its own inverse.
  static Vec2f folded(Vec2f p, float y) {
    if (!(y < 0)) return p;
    return {std::copysign(1 - std::fabs(p.y), p.x), std::copysign(1 - std::fabs(p.x), p.y)};
  }
  static int index(float x) { return std::clamp(static_cast<int>((x + 1) * (0.5f * kSide)), 0, kSide - 1); }
};

}  // namespace ohb::renderer
