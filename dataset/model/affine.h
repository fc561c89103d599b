// Affine transforms of scene files, in double since scenes scale by 0.01 and back.
#pragma once

#include <array>

#include "dataset/model/vec.h"

namespace ohb {

/// A position as files hold it, before it is stored in single precision.
struct Vec3d {
  double x = 0, y = 0, z = 0;
};

/// Three rows of four: p' = A p + t. The identity by default.
struct Affine {
  std::array<double, 12> m{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  double operator()(int row, int column) const { return m[static_cast<size_t>(row * 4 + column)]; }
  double& operator()(int row, int column) { return m[static_cast<size_t>(row * 4 + column)]; }
};

/// b first, then a.
inline Affine operator*(const Affine& a, const Affine& b) {
  Affine r;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 4; ++j)
      r(i, j) = a(i, 0) * b(0, j) + a(i, 1) * b(1, j) + a(i, 2) * b(2, j) + (j == 3 ? a(i, 3) : 0);
  return r;
}

inline Vec3f transformed(const Affine& a, double x, double y, double z) {
  const auto row = [&](int i) {
    return static_cast<float>(a(i, 0) * x + a(i, 1) * y + a(i, 2) * z + a(i, 3));
  };
  return {row(0), row(1), row(2)};
}

inline Vec3d transformed(const Affine& a, Vec3d p) {
  const auto row = [&](int i) { return a(i, 0) * p.x + a(i, 1) * p.y + a(i, 2) * p.z + a(i, 3); };
  return {row(0), row(1), row(2)};
}

/// Negative if the transform mirrors.
inline double determinant(const Affine& a) {
  return a(0, 0) * (a(1, 1) * a(2, 2) - a(1, 2) * a(2, 1)) -
         a(0, 1) * (a(1, 0) * a(2, 2) - a(1, 2) * a(2, 0)) +
         a(0, 2) * (a(1, 0) * a(2, 1) - a(1, 1) * a(2, 0));
}

}  // namespace ohb
