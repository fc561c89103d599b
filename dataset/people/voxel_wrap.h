// The closed surface around triangles, on a grid.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "dataset/people/surface_query.h"

namespace ohb::people {

struct WrappedSurface {
  std::vector<Vec3f> positions_cm;
  std::vector<std::array<uint32_t, 4>> quads;  // counter-clockwise from outside
};

/// The surface at a voxel's distance around what is solid: triangles, and what they enclose. Throws
/// InputError if the grid would have more than 64 million points.
WrappedSurface wrap(const std::vector<Vec3f>& positions_cm, const std::vector<SurfaceTriangle>& triangles,
                    float voxel_cm);

}  // namespace ohb::people
