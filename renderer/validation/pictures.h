// The pictures of a validation report.
#pragma once

#include <vector>

#include "dataset/model/image.h"
#include "dataset/model/vec.h"

namespace ohb::validation {

/// Linear premultiplied RGB over a light background as sRGB in [0,1], 3 channels, times `exposure`.
Image display_picture(const Image& rgb, const Image& coverage, float exposure);

/// The exposure that takes the 98th percentile of the covered pixels' brightest channel to 0.8; 1 if all
/// black.
float exposure_for(const Image& rgb, const Image& coverage);

/// Colour of x in [-1,1] (clamped) between blue (below), white and red (above), sRGB. ColorBrewer's RdBu
/// (Brewer 2003), readable with the usual colour deficiencies.
Vec3f diverging_colour(float x);

/// Each value over `limit` as a diverging colour; grey where `pixels` is 0. `values` has 1 channel.
Image diverging_picture(const Image& values, const std::vector<uint8_t>& pixels, float limit);

/// The least of 1, 2, 5 x 10^n that the 98th percentile of |values| in `pixels` does not exceed, at least
/// `least`.
float round_limit(const Image& values, const std::vector<uint8_t>& pixels, float least);

}  // namespace ohb::validation
