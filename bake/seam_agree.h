// Makes the two sides of every seam read the same, within the limit, at every point of it.
#pragma once

#include <vector>

#include "bake/seams.h"

namespace ohb::bake {

struct LevelMending {
  float most_changed = 0;      // of a texel inside a triangle
  bool is_swept_only = false;  // the seams read most of the level's texels
  size_t points_beyond = 0;    // that stay further apart than the limit; not counted if swept only
};

/// One map at one mip level: changes the texels that lookups along its seams read, as little as it can
/// (texels inside a triangle resist ten times as much as those of the background), until both sides are
/// within 1/255 (of sRGB for linear colours) or 1 degree of each other. Directions stay unit vectors, other
/// values within [0,1]. Where the seams read more than two thirds of the texels inside triangles only
/// SeamMender's sweeps are done.
///
/// After them most places agree. At the least change that meets the limits some places pull with some
/// strength, all others with none (Karush, Kuhn and Tucker). Strengths are found as Lawson's weights are
/// (1961): solve the weighted least squares exactly, multiply each place's weight by a power of how far
/// beyond the limit it is, again. Only windows around places beyond the limit take part; then windows around
/// those that are left, from where the first got to. Where points between places stay apart they become
/// places.
///
/// The order is fixed, so are the bits.
LevelMending mend_level(Image& map, const std::vector<Seam>& seams, const std::vector<uint8_t>& is_inside,
                        MapValues values);

}  // namespace ohb::bake
