// The texel centres that a triangle may hold, row by row: what every rasteriser of UVs walks over.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "dataset/surface/uv_geometry.h"

namespace ohb::surface {

/// Whole numbers i with low <= i + 0.5 <= high.
struct CentreRange {
  int64_t first, last;
  CentreRange(double low, double high)
      : first(static_cast<int64_t>(std::ceil(low - 0.5))),
        last(static_cast<int64_t>(std::floor(high - 0.5))) {}
};

/// Rows (upwards) and columns of texel space whose centres lie within `margin` of a triangle, or a little
/// further: of a long, thin one that lies askew most of the bounding box is left out. Never too few: rounding
/// is far below kSlack. The triangle must outlive it, and lie within 2^31 texels of the origin.
class TexelRows {
 public:
  TexelRows(const TexelTriangle& triangle, double margin)
      : triangle_(triangle),
        margin_(margin),
        rows_(triangle.low.y - margin, triangle.high.y + margin),
        columns_(triangle.low.x - margin, triangle.high.x + margin) {
    for (int i = 0; i < 3; ++i) {
      const TexelPoint edge = triangle.corner[(i + 1) % 3] - triangle.corner[i];
      per_row_[i] = edge.y != 0 ? edge.x / edge.y : 0;
    }
  }

  CentreRange rows() const { return rows_; }

  CentreRange columns(int64_t row) const {
    const double y = static_cast<double>(row) + 0.5;
    const double low_y = y - margin_ - kSlack, high_y = y + margin_ + kSlack;
    double left = std::numeric_limits<double>::infinity(), right = -left;
    for (int i = 0; i < 3; ++i) {
      const TexelPoint a = triangle_.corner[i], b = triangle_.corner[(i + 1) % 3];
      const double low = std::max(std::min(a.y, b.y), low_y), high = std::min(std::max(a.y, b.y), high_y);
      if (low > high) continue;
      const bool is_level = a.y == b.y;
      const double x = is_level ? a.x : a.x + (low - a.y) * per_row_[i];
      const double other_x = is_level ? b.x : a.x + (high - a.y) * per_row_[i];
      left = std::min({left, x, other_x});
      right = std::max({right, x, other_x});
    }
    if (left > right) return {0.5, -0.5};
    CentreRange range(left - margin_ - kSlack, right + margin_ + kSlack);
    range.first = std::max(range.first, columns_.first);
    range.last = std::min(range.last, columns_.last);
    return range;
  }

 private:
  static constexpr double kSlack = 0.25;

  const TexelTriangle& triangle_;
  double margin_;
  CentreRange rows_, columns_;
  double per_row_[3];  // how far each edge goes to the right on its way one row up
};

}  // namespace ohb::surface
