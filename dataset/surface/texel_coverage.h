// Which triangle each texel of a map shows: two passes, so that no bilinear lookup inside a triangle ever
// touches an undefined texel.
#pragma once

#include <cstdint>
#include <vector>

#include "dataset/surface/uv_geometry.h"

namespace ohb::surface {

struct UvTriangle {
  Vec2f uv[3];  // v up; may lie outside [0,1]: the map repeats
};

/// Largest extent of one triangle in UV units; beyond it the UVs are pixels or damaged.
constexpr float kMaxUvSpan = 8;
/// Largest UV coordinate, positive or negative: beyond it a float no longer resolves a texel.
constexpr float kMaxUv = 1024;

struct TexelCoverage {
  static constexpr uint32_t kNone = 0xffffffffu;
  static constexpr uint8_t kCentre = 1, kOverlapping = 2;

  int width_px = 0, height_px = 0;
  std::vector<uint32_t> owner;      // row 0 at the top; index of the triangle shown, or kNone
  uint64_t centre_texels = 0;       // whose centre lies in their owner
  uint64_t footprint_texels = 0;    // only touched by bilinear lookups into their owner
  uint64_t overlapping_texels = 0;  // whose centre lies in two or more triangles (shared edges do not count)
  std::vector<uint8_t> flags;  // one a texel: kCentre where it lies in its owner, kOverlapping in others too
  std::vector<uint32_t> triangles_without_texel;  // in ascending order
  std::vector<uint32_t> hidden_triangles;  // those of them that hold a centre: other triangles lie over them

  uint32_t owner_of(int x, int row) const { return owner[static_cast<size_t>(row) * width_px + x]; }
};

/// Pass 1: a texel belongs to the triangle that holds its centre (exact edge functions, top-left rule, so
/// neighbours neither both claim a texel nor leave a gap); where UVs overlap, to the first of them.
/// Pass 2: a texel that is still free belongs to the nearest triangle whose bilinear lookups read it: one
/// that touches the box of +-1 texel around its centre (the first of equals). So every triangle finds its
/// lookups defined, and one that is smaller than a texel still owns one unless others own all around it;
/// those are listed. UVs must be finite and within kMaxUv and kMaxUvSpan (std::logic_error).
/// The result does not depend on the number of threads. Memory: 5 bytes a texel.
enum class CoveragePasses { kCentres, kCentresAndFootprints };
TexelCoverage cover_texels(const std::vector<UvTriangle>& triangles, int width_px, int height_px,
                           CoveragePasses passes = CoveragePasses::kCentresAndFootprints);

/// The triangle in texel space, in the copy of the map that its UVs name.
TexelTriangle to_texel_space(const UvTriangle& triangle, int width_px, int height_px);

/// The point of the triangle nearest to the centre of texel (x, row), over all repetitions of the map.
NearestPoint nearest_point_of_texel(const TexelTriangle& triangle, int width_px, int height_px, int x,
                                    int row);

/// The point of its owner that a covered texel shows.
NearestPoint shown_point(const TexelCoverage& coverage, const std::vector<UvTriangle>& triangles, int x,
                         int row);

}  // namespace ohb::surface
