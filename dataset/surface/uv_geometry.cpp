#include "dataset/surface/uv_geometry.h"

#include <algorithm>
#include <cmath>

namespace ohb::surface {

double difference_of_products(double a, double d, double b, double c) {
  const double ad = a * d, bc = b * c, difference = ad - bc;
  // 3 roundings of at most 2^-53 each.
  constexpr double kRounding = 4.0 / 9007199254740992.0;
  if (std::abs(difference) > kRounding * (std::abs(ad) + std::abs(bc))) return difference;
  const double rest = std::fma(-b, c, bc);  // bc - b c, exactly
  return std::fma(a, d, -bc) + rest;
}

Edge::Edge(TexelPoint from, TexelPoint to) {
  reversed_ = to.y < from.y || (to.y == from.y && to.x < from.x);
  if (reversed_) std::swap(from, to);
  origin_ = from;
  direction_ = to - from;
  // In canonical order an edge goes up, or right where it is level. The triangle lies left of its own edges:
  // a left edge goes down, a top edge goes left; both are the reversed ones.
  owns_points_on_it_ = reversed_;
}

bool Edge::owns(TexelPoint p) const {
  const TexelPoint to_p = p - origin_;
  const double side = difference_of_products(direction_.x, to_p.y, direction_.y, to_p.x);
  if (side == 0) return owns_points_on_it_;
  return (side > 0) != reversed_;
}

bool Edge::is_box_outside(TexelPoint p, double half_size) const {
  const TexelPoint to_p = p - origin_;
  const double xy = direction_.x * to_p.y, yx = direction_.y * to_p.x;
  const double side = reversed_ ? yx - xy : xy - yx;
  const double reach = half_size * (std::abs(direction_.x) + std::abs(direction_.y));
  constexpr double kRounding = 1e-14;
  return side + reach < -kRounding * (std::abs(xy) + std::abs(yx) + reach);
}

TexelTriangle::TexelTriangle(TexelPoint a, TexelPoint b, TexelPoint c) : corner{a, b, c} {
  low = {std::min({a.x, b.x, c.x}), std::min({a.y, b.y, c.y})};
  high = {std::max({a.x, b.x, c.x}), std::max({a.y, b.y, c.y})};
  const TexelPoint ab = b - a, ac = c - a;
  const double twice_area = difference_of_products(ab.x, ac.y, ab.y, ac.x);
  is_degenerate = twice_area == 0;
  const TexelPoint second = twice_area < 0 ? c : b, third = twice_area < 0 ? b : c;
  edge[0] = Edge(a, second);
  edge[1] = Edge(second, third);
  edge[2] = Edge(third, a);
}

bool TexelTriangle::owns(TexelPoint p) const {
  return !is_degenerate && edge[0].owns(p) && edge[1].owns(p) && edge[2].owns(p);
}

bool TexelTriangle::touches_box(TexelPoint p, double half_size) const {
  if (p.x + half_size < low.x || p.x - half_size > high.x || p.y + half_size < low.y ||
      p.y - half_size > high.y)
    return false;
  // The edges of a degenerate triangle run both ways along one line, so this holds for it too.
  return !edge[0].is_box_outside(p, half_size) && !edge[1].is_box_outside(p, half_size) &&
         !edge[2].is_box_outside(p, half_size);
}

NearestPoint nearest_point(const TexelTriangle& triangle, TexelPoint p) {
  const TexelPoint* const corner = triangle.corner;
  NearestPoint nearest{{1, 0, 0}, INFINITY};
  if (!triangle.is_degenerate) {
    const TexelPoint ab = corner[1] - corner[0], ac = corner[2] - corner[0], ap = p - corner[0];
    const double area = difference_of_products(ab.x, ac.y, ab.y, ac.x);
    const double v = difference_of_products(ap.x, ac.y, ap.y, ac.x) / area;
    const double w = difference_of_products(ab.x, ap.y, ab.y, ap.x) / area;
    if (v >= 0 && w >= 0 && v + w <= 1) return {{1 - v - w, v, w}, 0};
  }
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    const TexelPoint side = corner[j] - corner[i], to_p = p - corner[i];
    const double squared_length = dot(side, side);
    const double t = squared_length > 0 ? std::clamp(dot(to_p, side) / squared_length, 0.0, 1.0) : 0.0;
    const TexelPoint apart = {to_p.x - t * side.x, to_p.y - t * side.y};
    const double squared_distance = dot(apart, apart);
    if (squared_distance >= nearest.squared_distance) continue;
    nearest = {{0, 0, 0}, squared_distance};
    nearest.weights[i] = 1 - t;
    nearest.weights[j] = t;
  }
  return nearest;
}

}  // namespace ohb::surface
