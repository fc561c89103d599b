// Padding: the background of a map is filled so that every mip level is safe to read at the charts' borders.
#pragma once

#include <vector>

#include "dataset/model/image.h"

namespace ohb::surface {

/// Fills the texels where is_covered is 0 by pull-push (Gortler et al. 1996, "The lumigraph", section 3.4):
/// averages of the covered texels are pulled down a pyramid of halved images, then pushed back up into the
/// holes, bilinearly. Covered texels keep their exact value. If nothing is covered all becomes 0.
/// is_covered: one byte a texel, 0 or 1, width x height. Memory: beyond a byte a texel only what the holes
/// need, at most 0.34 of the image. Any thread count, same bits.
void pad(Image& image, const std::vector<uint8_t>& is_covered);

/// As pad for unit vectors of a tangent-space normal map: what it fills is normalised, and (0,0,1) where
/// nothing remains. Inside charts nothing changes; next to a chart the fill continues that chart's own frame.
void pad_normals(Image& image, const std::vector<uint8_t>& is_covered);

/// The image, padded, and its halvings down to one texel: at each level the means of the covered texels
/// alone, and holes filled as pad fills them. Empty `is_covered`: all are.
std::vector<Image> padded_levels(Image image, std::vector<uint8_t> is_covered);

}  // namespace ohb::surface
