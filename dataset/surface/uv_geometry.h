// Plane geometry of triangles in texel space: the predicates that decide which texel shows which triangle.
//
// Texel space of a map of W x H texels: x = u W, y = v H, y up. Texel (i, r), r counted from the top, has its
// centre at (i + 0.5, H - r - 0.5). Products of a float and an integer below 2^29 are exact in double.
#pragma once

#include "dataset/model/vec.h"

namespace ohb::surface {

struct TexelPoint {
  double x = 0, y = 0;
};

inline TexelPoint operator-(TexelPoint a, TexelPoint b) {
  return {a.x - b.x, a.y - b.y};
}
inline double dot(TexelPoint a, TexelPoint b) {
  return a.x * b.x + a.y * b.y;
}

/// a x d - b x c with the sign of the exact value (floating-point filter, then Kahan's algorithm with fma;
/// Jeannerod, Louvet and Muller 2013), for finite arguments without underflow.
double difference_of_products(double a, double d, double b, double c);

/// An edge of a counter-clockwise triangle, as the top-left rule sees it.
class Edge {
 public:
  Edge() = default;
  Edge(TexelPoint from, TexelPoint to);

  /// Whether p is strictly left of the edge, or on it where it is a left or a top edge. For two triangles
  /// that share the edge in opposite directions, exactly one of them answers true.
  bool owns(TexelPoint p) const;
  /// Whether the open box of that half size around p lies entirely right of the edge.
  bool is_box_outside(TexelPoint p, double half_size) const;

 private:
  TexelPoint origin_, direction_;  // in canonical order, so that both triangles compute the same bits
  bool reversed_ = false, owns_points_on_it_ = false;
};

/// A triangle in texel space, counter-clockwise (mirrored triangles are turned round).
struct TexelTriangle {
  TexelPoint corner[3];        // in the order of the triangle
  Edge edge[3];                // of the counter-clockwise order
  TexelPoint low, high;        // bounding box
  bool is_degenerate = false;  // no area in UV

  TexelTriangle(TexelPoint a, TexelPoint b, TexelPoint c);

  /// By the top-left rule; always false for a degenerate triangle.
  bool owns(TexelPoint p) const;
  /// Whether the closed box of that half size around p touches the closed triangle (or says so wrongly within
  /// rounding, never the other way round). Separating axes: Akenine-Moller 2001, in two dimensions.
  bool touches_box(TexelPoint p, double half_size) const;
};

/// The point of the triangle nearest to p.
struct NearestPoint {
  double weights[3];  // barycentric, each in [0,1], sum 1
  double squared_distance;
};
NearestPoint nearest_point(const TexelTriangle& triangle, TexelPoint p);

}  // namespace ohb::surface
