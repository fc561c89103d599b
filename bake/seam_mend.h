// Makes both sides of each seam read the same value.
#pragma once

#include <vector>

#include "bake/seams.h"

namespace ohb {

/// Mip levels 0 and 1. Coarser ones depend on texels of other charts wherever charts lie closer than the
/// blocks are long, so making them agree would spoil level 0; the band of seam_fill.h is what they get.
constexpr int kMendLevels = 2;
constexpr int kMendSweeps = 24;

/// Kaczmarz's method (1937), damped: lookups on the two sides of a seam that differ are each moved half the
/// way by the smallest change of the texels that they read, edge by edge, the coarse level first, over and
/// over until they agree within `tolerance` or for kMendSweeps sweeps. The background gives way first; texels
/// inside triangles (is_inside 1) a tenth as much, at level 0 only. The order is fixed, so are the bits.
/// Normals stay unit vectors, other values within [0,1]. Gives the greatest change of a texel inside a
/// triangle.
float mend_seams(Image& map, const std::vector<Seam>& seams, const std::vector<uint8_t>& is_inside,
                 MapValues values, float tolerance);

}  // namespace ohb
