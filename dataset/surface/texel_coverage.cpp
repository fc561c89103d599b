#include "dataset/surface/texel_coverage.h"

#include <tbb/parallel_for.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "dataset/surface/texel_rows.h"

namespace ohb::surface {
namespace {

constexpr int kBandRows = 64;
constexpr double kFootprint = 1;  // bilinear lookups reach less than one texel from a centre
constexpr double kOwned = -1, kOverlapCounted = -2;

int64_t wrapped(int64_t i, int size) {
  const int64_t rest = i % size;
  return rest < 0 ? rest + size : rest;
}

/// The rows [first_row, last_row] (counted upwards, within the map) that one task fills.
struct Band {
  int first_row, last_row;
  std::vector<uint32_t> triangles;  // ascending
};

class BandPainter {
 public:
  BandPainter(const Band& band, TexelCoverage& coverage)
      : band_(band),
        coverage_(coverage),
        width_(coverage.width_px),
        height_(coverage.height_px),
        distance_(static_cast<size_t>(width_) * (band.last_row - band.first_row + 1),
                  std::numeric_limits<double>::infinity()) {}

  void paint_centres(const TexelTriangle& triangle, uint32_t index) {
    if (triangle.is_degenerate) return;
    for_each_texel(triangle, 0, [&](TexelPoint centre, uint32_t& owner, double& distance) {
      if (!triangle.owns(centre)) return;
      if (distance == kOverlapCounted) return;
      if (distance == kOwned) {
        distance = kOverlapCounted;
        coverage_.flags[&owner - coverage_.owner.data()] |= TexelCoverage::kOverlapping;
        ++overlapping_;
        return;
      }
      owner = index;
      coverage_.flags[&owner - coverage_.owner.data()] = TexelCoverage::kCentre;
      distance = kOwned;
      ++centres_;
    });
  }

  void paint_footprints(const TexelTriangle& triangle, uint32_t index) {
    for_each_texel(triangle, kFootprint, [&](TexelPoint centre, uint32_t& owner, double& distance) {
      if (distance < 0 || !triangle.touches_box(centre, kFootprint)) return;
      const double found = nearest_point(triangle, centre).squared_distance;
      if (found >= distance) return;
      if (owner == TexelCoverage::kNone) ++footprints_;
      owner = index;
      distance = found;
    });
  }

  uint64_t centres() const { return centres_; }
  uint64_t footprints() const { return footprints_; }
  uint64_t overlapping() const { return overlapping_; }

 private:
  /// Calls visit(centre, owner, distance) for each texel centre of the band in the triangle's box grown by
  /// `margin`, in the triangle's own copy of the map.
  template <typename Visit>
  void for_each_texel(const TexelTriangle& triangle, double margin, const Visit& visit) {
    const TexelRows reach(triangle, margin);
    const CentreRange rows = reach.rows();
    const int64_t first_copy = floor_of(rows.first), last_copy = floor_of(rows.last);
    for (int64_t copy = first_copy; copy <= last_copy; ++copy) {
      const int64_t low = std::max<int64_t>(rows.first, copy * height_ + band_.first_row);
      const int64_t high = std::min<int64_t>(rows.last, copy * height_ + band_.last_row);
      for (int64_t row = low; row <= high; ++row) {
        const int row_up = static_cast<int>(row - copy * height_);
        uint32_t* const owners = &coverage_.owner[static_cast<size_t>(height_ - 1 - row_up) * width_];
        double* const distances = &distance_[static_cast<size_t>(row_up - band_.first_row) * width_];
        const double y = static_cast<double>(row) + 0.5;
        const CentreRange columns = reach.columns(row);
        int64_t column = wrapped(columns.first, width_);
        for (int64_t i = columns.first; i <= columns.last; ++i) {
          visit({static_cast<double>(i) + 0.5, y}, owners[column], distances[column]);
          if (++column == width_) column = 0;
        }
      }
    }
  }
  int64_t floor_of(int64_t row) const { return (row - wrapped(row, height_)) / height_; }

  const Band& band_;
  TexelCoverage& coverage_;
  int width_, height_;
  std::vector<double> distance_;  // squared, of pass 2; or kOwned, kOverlapCounted
  uint64_t centres_ = 0, footprints_ = 0, overlapping_ = 0;
};

std::vector<Band> make_bands(const std::vector<TexelTriangle>& triangles, int height) {
  std::vector<Band> bands;
  for (int row = 0; row < height; row += kBandRows)
    bands.push_back({row, std::min(row + kBandRows, height) - 1, {}});
  for (size_t t = 0; t < triangles.size(); ++t) {
    const CentreRange rows(triangles[t].low.y - kFootprint, triangles[t].high.y + kFootprint);
    if (rows.last - rows.first + 1 >= height) {
      for (Band& band : bands) band.triangles.push_back(static_cast<uint32_t>(t));
      continue;
    }
    const int64_t first = wrapped(rows.first, height) / kBandRows,
                  last = wrapped(rows.last, height) / kBandRows;
    const int64_t count = static_cast<int64_t>(bands.size());
    // From the first band on, round the top, to the last; all of them where it comes back to the first.
    const bool goes_round = wrapped(rows.last, height) < wrapped(rows.first, height);
    const int64_t steps = goes_round ? std::min(count - 1, count - first + last) : last - first;
    for (int64_t i = 0; i <= steps; ++i)
      bands[(first + i) % count].triangles.push_back(static_cast<uint32_t>(t));
  }
  return bands;
}

/// Whether the triangle holds the centre of any texel.
bool holds_a_centre(const TexelTriangle& triangle) {
  const CentreRange columns(triangle.low.x, triangle.high.x), rows(triangle.low.y, triangle.high.y);
  for (int64_t row = rows.first; row <= rows.last; ++row)
    for (int64_t i = columns.first; i <= columns.last; ++i)
      if (triangle.owns({static_cast<double>(i) + 0.5, static_cast<double>(row) + 0.5})) return true;
  return false;
}

void check_uvs(const std::vector<UvTriangle>& triangles) {
  for (const UvTriangle& triangle : triangles)
    for (int i = 0; i < 3; ++i) {
      const Vec2f a = triangle.uv[i], b = triangle.uv[(i + 1) % 3];
      if (!is_finite(a) || !(std::abs(a.x) <= kMaxUv && std::abs(a.y) <= kMaxUv) ||
          !(std::abs(a.x - b.x) <= kMaxUvSpan && std::abs(a.y - b.y) <= kMaxUvSpan))
        throw std::logic_error("cover_texels: UVs out of range");
    }
}

}  // namespace

TexelTriangle to_texel_space(const UvTriangle& triangle, int width_px, int height_px) {
  TexelPoint corner[3];
  for (int i = 0; i < 3; ++i)
    corner[i] = {static_cast<double>(triangle.uv[i].x) * width_px,
                 static_cast<double>(triangle.uv[i].y) * height_px};
  return TexelTriangle(corner[0], corner[1], corner[2]);
}

NearestPoint nearest_point_of_texel(const TexelTriangle& triangle, int width_px, int height_px, int x,
                                    int row) {
  const double centre_x = x + 0.5, centre_y = height_px - row - 0.5;
  const auto first_copy = [](double low, double centre, int size) {
    return std::ceil((low - kFootprint - centre) / size);
  };
  NearestPoint nearest{{1, 0, 0}, std::numeric_limits<double>::infinity()};
  const double left = first_copy(triangle.low.x, centre_x, width_px);
  const double bottom = first_copy(triangle.low.y, centre_y, height_px);
  for (double j = bottom; centre_y + j * height_px <= triangle.high.y + kFootprint; ++j)
    for (double i = left; centre_x + i * width_px <= triangle.high.x + kFootprint; ++i) {
      const NearestPoint found = nearest_point(triangle, {centre_x + i * width_px, centre_y + j * height_px});
      if (found.squared_distance < nearest.squared_distance) nearest = found;
    }
  return nearest;
}

NearestPoint shown_point(const TexelCoverage& coverage, const std::vector<UvTriangle>& triangles, int x,
                         int row) {
  const int width = coverage.width_px, height = coverage.height_px;
  const TexelTriangle triangle = to_texel_space(triangles[coverage.owner_of(x, row)], width, height);
  return nearest_point_of_texel(triangle, width, height, x, row);
}

TexelCoverage cover_texels(const std::vector<UvTriangle>& triangles, int width_px, int height_px,
                           CoveragePasses passes) {
  check_uvs(triangles);
  TexelCoverage coverage;
  coverage.width_px = width_px;
  coverage.height_px = height_px;
  coverage.owner.assign(static_cast<size_t>(width_px) * height_px, TexelCoverage::kNone);
  coverage.flags.assign(coverage.owner.size(), 0);
  std::vector<TexelTriangle> in_texels;
  in_texels.reserve(triangles.size());
  for (const UvTriangle& triangle : triangles)
    in_texels.push_back(to_texel_space(triangle, width_px, height_px));

  const std::vector<Band> bands = make_bands(in_texels, height_px);
  std::atomic<uint64_t> centres{0}, footprints{0}, overlapping{0};
  tbb::parallel_for(size_t{0}, bands.size(), [&](size_t b) {
    BandPainter painter(bands[b], coverage);
    for (uint32_t t : bands[b].triangles) painter.paint_centres(in_texels[t], t);
    if (passes == CoveragePasses::kCentresAndFootprints)
      for (uint32_t t : bands[b].triangles) painter.paint_footprints(in_texels[t], t);
    centres += painter.centres();
    footprints += painter.footprints();
    overlapping += painter.overlapping();
  });
  coverage.centre_texels = centres;
  coverage.footprint_texels = footprints;
  coverage.overlapping_texels = overlapping;

  std::vector<bool> has_texel(triangles.size(), false);
  for (uint32_t owner : coverage.owner)
    if (owner != TexelCoverage::kNone) has_texel[owner] = true;
  for (size_t t = 0; t < triangles.size(); ++t)
    if (!has_texel[t]) coverage.triangles_without_texel.push_back(static_cast<uint32_t>(t));
  for (uint32_t t : coverage.triangles_without_texel)
    if (holds_a_centre(in_texels[t])) coverage.hidden_triangles.push_back(t);
  return coverage;
}

}  // namespace ohb::surface
