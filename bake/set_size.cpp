#include "bake/set_size.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bake/bake.h"

namespace ohb::bake {
namespace {

/// A few texels for each triangle.
int edge_for_vertex_colours(size_t triangles) {
  int edge = kSizeWithoutPicture_px;
  while (edge < kMaxMapSize_px && static_cast<size_t>(edge) * edge < 4 * triangles) edge *= 2;
  return edge;
}

}  // namespace

MapSize size_of_set(const ScanMaterial& material, size_t triangles, int wanted_px, int source_edge_px) {
  int width = material.has_vertex_colours ? edge_for_vertex_colours(triangles) : kSizeWithoutPicture_px;
  int height = width;
  if (!material.diffuse.empty()) {
    const ImageFileInfo info = probe_image(material.diffuse);
    width = info.width_px;
    height = info.height_px;
  } else if (source_edge_px > 0) {
    width = height = source_edge_px;
  }
  const int longer = std::max(width, height);
  const int target = wanted_px > 0 ? wanted_px : std::min(longer, kMaxMapSize_px);
  const auto scaled = [&](int edge) {
    return std::max(1, static_cast<int>(std::lround(static_cast<double>(edge) * target / longer)));
  };
  return {scaled(width), scaled(height)};
}

std::string mask_size_of(const ScanMaterial& material) {
  if (material.diffuse.empty() || material.alpha.empty()) return "";
  const ImageFileInfo colour = probe_image(material.diffuse), mask = probe_image(material.alpha);
  if (colour.width_px == mask.width_px && colour.height_px == mask.height_px) return "";
  return fmt::format("{} x {} of {} x {}", mask.width_px, mask.height_px, colour.width_px, colour.height_px);
}

}  // namespace ohb::bake
