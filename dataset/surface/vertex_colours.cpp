#include "dataset/surface/vertex_colours.h"

#include <tbb/parallel_for.h>

namespace ohb::surface {

void multiply_vertex_colours(const Scan& scan, const std::vector<std::array<uint32_t, 3>>& corners,
                             const std::vector<UvTriangle>& uvs, const TexelCoverage& coverage,
                             Image& image) {
  if (scan.corner_colours.empty()) return;
  const int width = coverage.width_px, height = coverage.height_px;
  tbb::parallel_for(0, height, [&](int row) {
    for (int x = 0; x < width; ++x) {
      const uint32_t owner = coverage.owner_of(x, row);
      if (owner == TexelCoverage::kNone) continue;
      const NearestPoint point =
          nearest_point_of_texel(to_texel_space(uvs[owner], width, height), width, height, x, row);
      float factor[4] = {0, 0, 0, 0};
      for (size_t k = 0; k < 3; ++k) {
        const VertexColour& colour = scan.corner_colours[corners[owner][k]];
        const auto share = static_cast<float>(point.weights[k]);
        for (int c = 0; c < 3; ++c) factor[c] += share * colour.rgb[c];
        factor[3] += share * colour.alpha;
      }
      float* const pixel = image.pixel(x, row);
      if (image.channels == 1)
        pixel[0] *= factor[3];
      else
        for (int c = 0; c < 3; ++c) pixel[c] *= factor[c];
    }
  });
}

Vec3f mean_vertex_colour(const Scan& scan, size_t face) {
  if (scan.corner_colours.empty()) return {1, 1, 1};
  Vec3f sum;
  const size_t first = scan.face_begin[face], end = scan.face_begin[face + 1];
  for (size_t c = first; c < end; ++c) sum += scan.corner_colours[c].rgb;
  return sum * (1.0f / static_cast<float>(end - first));
}

}  // namespace ohb::surface
