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

/// The distance of neighbouring single-precision numbers at the far end of the range.
double single_step(const Range& range) {
  const double farthest = std::max(std::abs(range.low), std::abs(range.high));
  return farthest > 0 ? std::ldexp(1.0, std::ilogb(farthest) - 23) : 0;
}

/// Where single precision is so coarse that it shows, whether all numbers are ones that it can hold. 0: no;
/// else the coarsest step. A program that wrote them has lost the rest; none that keeps double does so.
double lost_step(const std::vector<Vec3d>& positions, const Range (&ranges)[3], double diagonal) {
  constexpr double kShows = 1e-4;    // of the diagonal: 0.2 mm of a person
  constexpr double kWritten = 0.02;  // of a step: what few decimals leave
  double coarsest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double step = single_step(ranges[axis]);
    if (step < kShows * diagonal) continue;
    for (const Vec3d& p : positions) {
      const double steps = (axis == 0 ? p.x : axis == 1 ? p.y : p.z) / step;
      if (std::abs(steps - std::round(steps)) > kWritten) return 0;
    }
    coarsest = std::max(coarsest, step);
  }
  return coarsest;
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
    const double lost = lost_step(positions, {x, y, z}, diagonal);
    if (lost > 0)
      scan.notes.push_back(
          "its coordinates lie in steps of " + written(lost) +
          ", as single precision holds them out there: finer detail was lost before the file "
          "was written; export it with the offset taken off in the program that has it");
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
