// Colours at a scan's vertices, as the texels of a map see them.
#pragma once

#include <array>
#include <vector>

#include "dataset/model/image.h"
#include "dataset/model/scan.h"
#include "dataset/surface/texel_coverage.h"

namespace ohb::surface {

/// Multiplies each covered texel of a 3-channel image by the colours (linear) at its owner's corners, of a
/// 1-channel image by their alpha: interpolated at the point of the owner nearest to the texel's centre.
/// `corners`: of each triangle of the coverage, into Scan::corners. Does nothing to a scan without colours.
void multiply_vertex_colours(const Scan& scan, const std::vector<std::array<uint32_t, 3>>& corners,
                             const std::vector<UvTriangle>& uvs, const TexelCoverage& coverage, Image& image);

/// Mean over a face's corners, linear; 1 without colours.
Vec3f mean_vertex_colour(const Scan& scan, size_t face);

}  // namespace ohb::surface
