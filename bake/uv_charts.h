// The charts of a texture set: groups of triangles that touch in UV.
#pragma once

#include <cstdint>
#include <vector>

#include "dataset/model/model.h"
#include "dataset/surface/texel_coverage.h"

namespace ohb::bake {

struct UvChart {
  double width_texels = 0, height_texels = 0;  // of its bounding box in the map
  float diagonal_cm = 0;                       // of its bounding box in space
};

struct UvCharts {
  std::vector<uint32_t> chart_of;  // one a triangle
  std::vector<UvChart> charts;
};

/// Triangles that have a bitwise equal UV belong to one chart. `triangles`: indices into the model's; `uvs`:
/// of each of them.
UvCharts find_charts(const Model& model, const std::vector<uint32_t>& triangles,
                     const std::vector<surface::UvTriangle>& uvs, int width_px, int height_px);

/// Those of `triangles` whose edges can be seams: with an area in UV, not under another triangle, and of a
/// chart of two texels or more either way. Where both sides of an edge are made to agree, the texels of any
/// other would have to hold their whole chart's surroundings, or belong to a face elsewhere.
std::vector<uint32_t> triangles_with_seams(const UvCharts& charts, const std::vector<uint32_t>& triangles,
                                           const std::vector<surface::UvTriangle>& uvs,
                                           const surface::TexelCoverage& coverage);

}  // namespace ohb::bake
