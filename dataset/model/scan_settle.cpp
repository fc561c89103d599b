// What all readers leave to one place: positions far from the origin, and what opacity comes to.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "dataset/model/scan_readers.h"

namespace ohb {
namespace {

/// At this many diagonals from the origin single precision is off by 6e-6 diagonals: 0.01 mm of a person.
constexpr double kFarAway = 100;

struct Range {
  double low = INFINITY, high = -INFINITY;
  void add(double x) {
    low = std::min(low, x);
    high = std::max(high, x);
  }
  double middle() const { return low + (high - low) / 2; }
};

std::string written(double x) {
  char text[40];
  std::snprintf(text, sizeof text, "%.10g", x);
  return text;
}

}  // namespace

void store_positions(Scan& scan, const std::vector<Vec3d>& positions) {
  Range x, y, z;
  bool all_finite = true;
  for (const Vec3d& p : positions) {
    x.add(p.x);
    y.add(p.y);
    z.add(p.z);
    all_finite = all_finite && std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
  }
  Vec3d offset;
  const double diagonal = std::hypot(x.high - x.low, y.high - y.low, z.high - z.low);
  double farthest = 0;
  for (const Range& range : {x, y, z})
    farthest = std::max({farthest, std::abs(range.low), std::abs(range.high)});
  if (all_finite && !positions.empty() && diagonal > 0 && farthest > kFarAway * diagonal) {
    const double step = std::pow(10, std::floor(std::log10(diagonal)));
    const auto rounded = [&](const Range& range) { return std::round(range.middle() / step) * step; };
    offset = {rounded(x), rounded(y), rounded(z)};
    scan.removed_offset = offset;
    scan.notes.push_back("lies far from the origin: (" + written(offset.x) + ", " + written(offset.y) + ", " +
                         written(offset.z) + ") is taken off all positions");
  }
  scan.positions.clear();
  scan.positions.reserve(positions.size());
  for (const Vec3d& p : positions)
    scan.positions.push_back({static_cast<float>(p.x - offset.x), static_cast<float>(p.y - offset.y),
                              static_cast<float>(p.z - offset.z)});
}

void settle_opacity(Scan& scan) {
  for (size_t f = 0; f < scan.face_count() && !scan.corner_colours.empty(); ++f) {
    ScanMaterial& material = scan.materials[scan.face_material[f]];
    for (size_t c = scan.face_begin[f]; c < scan.face_begin[f + 1]; ++c) {
      const VertexColour& colour = scan.corner_colours[c];
      const bool is_white = colour.rgb.x == 1 && colour.rgb.y == 1 && colour.rgb.z == 1;
      material.has_vertex_colours = material.has_vertex_colours || !is_white;
      material.has_vertex_alpha = material.has_vertex_alpha || colour.alpha < 1;
    }
  }
  for (ScanMaterial& material : scan.materials)
    if (material.alpha.empty() && !material.has_vertex_alpha && material.alpha_cutoff) {
      material.opacity = material.opacity_of(1);
      material.alpha_cutoff.reset();
    }
}

}  // namespace ohb
