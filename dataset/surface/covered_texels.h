// The loop over the texels of a map that show the surface.
#pragma once

#include <tbb/parallel_for.h>

#include "dataset/surface/texel_coverage.h"

namespace ohb::surface {

/// Calls at(x, row, owner) for each texel that shows a triangle; rows side by side.
template <typename At>
void for_each_covered_texel(const TexelCoverage& coverage, const At& at) {
  tbb::parallel_for(0, coverage.height_px, [&](int row) {
    for (int x = 0; x < coverage.width_px; ++x)
      if (const uint32_t owner = coverage.owner_of(x, row); owner != TexelCoverage::kNone) at(x, row, owner);
  });
}

}  // namespace ohb::surface
