// Polygons into triangles. Labels index faces, so every face yields its corner count minus two triangles.
#include <algorithm>
#include <cmath>

#include "dataset/model/scan.h"

namespace ohb {
namespace {

struct Vec2d {
  double x, y;
};
double cross_of(Vec2d o, Vec2d a, Vec2d b) {
  return (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x);
}

Vec3f corner_position(const Scan& scan, uint32_t corner) {
  return scan.positions[scan.corners[corner].position];
}

/// True if the two triangles that the diagonal makes face opposite ways, so that one lies outside the quad.
bool folds_over(Vec3f a, Vec3f b, Vec3f c, Vec3f d) {  // diagonal a-c
  return dot(cross(b - a, c - a), cross(c - a, d - a)) < 0;
}

void split_quad(const Scan& scan, uint32_t face, std::vector<ScanTriangle>& triangles) {
  const uint32_t c = scan.face_begin[face];
  const Vec3f p[4] = {corner_position(scan, c), corner_position(scan, c + 1), corner_position(scan, c + 2),
                      corner_position(scan, c + 3)};
  bool second = dot(p[3] - p[1], p[3] - p[1]) < dot(p[2] - p[0], p[2] - p[0]);
  const bool folds_02 = folds_over(p[0], p[1], p[2], p[3]), folds_13 = folds_over(p[1], p[2], p[3], p[0]);
  if (folds_02 != folds_13) second = folds_02;
  if (second) {
    triangles.push_back({{c, c + 1, c + 3}, face});
    triangles.push_back({{c + 1, c + 2, c + 3}, face});
  } else {
    triangles.push_back({{c, c + 1, c + 2}, face});
    triangles.push_back({{c, c + 2, c + 3}, face});
  }
}

/// The polygon in the plane of its Newell normal, counter-clockwise.
std::vector<Vec2d> project(const Scan& scan, uint32_t begin, uint32_t end) {
  double n[3] = {0, 0, 0};
  for (uint32_t c = begin; c < end; ++c) {
    const Vec3f a = corner_position(scan, c), b = corner_position(scan, c + 1 < end ? c + 1 : begin);
    n[0] += (static_cast<double>(a.y) - b.y) * (static_cast<double>(a.z) + b.z);
    n[1] += (static_cast<double>(a.z) - b.z) * (static_cast<double>(a.x) + b.x);
    n[2] += (static_cast<double>(a.x) - b.x) * (static_cast<double>(a.y) + b.y);
  }
  int drop = 2;
  if (std::abs(n[0]) >= std::abs(n[1]) && std::abs(n[0]) >= std::abs(n[2])) {
    drop = 0;
  } else if (std::abs(n[1]) >= std::abs(n[2])) {
    drop = 1;
  }
  const int u = (drop + 1) % 3, v = (drop + 2) % 3;
  const double sign = n[drop] < 0 ? -1 : 1;
  std::vector<Vec2d> flat;
  for (uint32_t c = begin; c < end; ++c) {
    const Vec3f p = corner_position(scan, c);
    flat.push_back({sign * p[u], p[v]});
  }
  return flat;
}

/// True if the triangle at `i` of the remaining ring turns left and holds no other corner.
bool is_ear(const std::vector<Vec2d>& flat, const std::vector<uint32_t>& ring, size_t i) {
  const size_t n = ring.size();
  const uint32_t ia = ring[(i + n - 1) % n], ib = ring[i], ic = ring[(i + 1) % n];
  const Vec2d a = flat[ia], b = flat[ib], c = flat[ic];
  if (cross_of(a, b, c) <= 0) return false;
  return std::none_of(ring.begin(), ring.end(), [&](uint32_t j) {
    if (j == ia || j == ib || j == ic) return false;
    const Vec2d p = flat[j];
    const bool is_corner =
        (p.x == a.x && p.y == a.y) || (p.x == b.x && p.y == b.y) || (p.x == c.x && p.y == c.y);
    return !is_corner && cross_of(a, b, p) >= 0 && cross_of(b, c, p) >= 0 && cross_of(c, a, p) >= 0;
  });
}

void clip_ears(const Scan& scan, uint32_t face, std::vector<ScanTriangle>& triangles) {
  const uint32_t begin = scan.face_begin[face], end = scan.face_begin[face + 1];
  const std::vector<Vec2d> flat = project(scan, begin, end);
  std::vector<uint32_t> ring(end - begin);
  for (uint32_t i = 0; i < ring.size(); ++i) ring[i] = i;
  size_t start = 0;
  while (ring.size() > 3) {
    const size_t n = ring.size();
    size_t ear = start % n, tried = 0;
    while (tried < n && !is_ear(flat, ring, ear)) {
      ear = (ear + 1) % n;
      ++tried;
    }
    if (tried == n) break;
    triangles.push_back(
        {{begin + ring[(ear + n - 1) % n], begin + ring[ear], begin + ring[(ear + 1) % n]}, face});
    ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(ear));
    start = ear;
  }
  // One triangle is left, or a degenerate or self-crossing rest without ears: a fan.
  for (size_t i = 1; i + 1 < ring.size(); ++i)
    triangles.push_back({{begin + ring[0], begin + ring[i], begin + ring[i + 1]}, face});
}

}  // namespace

std::vector<ScanTriangle> triangulate(const Scan& scan) {
  std::vector<ScanTriangle> triangles;
  triangles.reserve(scan.corners.size() - 2 * scan.face_count());
  for (uint32_t f = 0; f < scan.face_count(); ++f) {
    const uint32_t begin = scan.face_begin[f], count = scan.face_begin[f + 1] - begin;
    if (count == 3) {
      triangles.push_back({{begin, begin + 1, begin + 2}, f});
    } else if (count == 4) {
      split_quad(scan, f, triangles);
    } else {
      clip_ears(scan, f, triangles);
    }
  }
  return triangles;
}

}  // namespace ohb
