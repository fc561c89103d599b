#include "dataset/model/model.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "dataset/model/model_files.h"
#include "dataset/model/parallel.h"
#include "dataset/model/regions.h"

namespace ohb {
namespace {

struct Vec3d {
  double x = 0, y = 0, z = 0;
};

Vec3d difference(Vec3f a, Vec3f b) {
  return {double(a.x) - b.x, double(a.y) - b.y, double(a.z) - b.z};
}
double dot(Vec3d a, Vec3d b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
Vec3d cross(Vec3d a, Vec3d b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Angle between a and b, accurate for tiny and flat angles too (Kahan: atan2 of cross and dot).
double angle_between(Vec3d a, Vec3d b) {
  const Vec3d c = cross(a, b);
  return std::atan2(std::sqrt(dot(c, c)), dot(a, b));
}

}  // namespace

std::vector<Vec3f> smooth_normals(const Model& model) {
  // The unit normal of each triangle weighted by its angle at each corner; then summed in their order.
  std::vector<std::array<Vec3d, 3>> weighted(model.triangles.size());
  parallel_for_each(0, static_cast<int>(weighted.size()), [&](int i) {
    const auto t = static_cast<size_t>(i);
    const ModelTriangle& triangle = model.triangles[t];
    const Vec3f p[3] = {model.positions_cm[triangle.position[0]], model.positions_cm[triangle.position[1]],
                        model.positions_cm[triangle.position[2]]};
    const Vec3d face = cross(difference(p[1], p[0]), difference(p[2], p[0]));
    const double twice_area = std::sqrt(dot(face, face));
    if (!(twice_area > 0)) return;
    for (int c = 0; c < 3; ++c) {
      const double angle = angle_between(difference(p[(c + 1) % 3], p[c]), difference(p[(c + 2) % 3], p[c]));
      weighted[t][c] = {angle * face.x / twice_area, angle * face.y / twice_area,
                        angle * face.z / twice_area};
    }
  });
  std::vector<Vec3d> sums(model.positions_cm.size());
  for (size_t t = 0; t < weighted.size(); ++t)
    for (int c = 0; c < 3; ++c) {
      Vec3d& sum = sums[model.triangles[t].position[c]];
      sum.x += weighted[t][c].x;
      sum.y += weighted[t][c].y;
      sum.z += weighted[t][c].z;
    }
  std::vector<Vec3f> normals(sums.size(), Vec3f{0, 0, 1});
  for (size_t i = 0; i < sums.size(); ++i) {
    const double size = std::sqrt(dot(sums[i], sums[i]));
    if (size > 1e-12)
      normals[i] = {float(sums[i].x / size), float(sums[i].y / size), float(sums[i].z / size)};
  }
  return normals;
}

Bounds bounds_of(const std::vector<Vec3f>& positions) {
  if (positions.empty()) return {};
  Bounds bounds{positions[0], positions[0]};
  for (const Vec3f& p : positions) {
    bounds.low = {std::min(bounds.low.x, p.x), std::min(bounds.low.y, p.y), std::min(bounds.low.z, p.z)};
    bounds.high = {std::max(bounds.high.x, p.x), std::max(bounds.high.y, p.y), std::max(bounds.high.z, p.z)};
  }
  return bounds;
}

std::string mesh_fault(const Model& model, size_t set_count) {
  if (model.triangles.empty()) return "there are no triangles";
  for (size_t i = 0; i < model.positions_cm.size(); ++i)
    if (!is_finite(model.positions_cm[i])) return "position " + std::to_string(i) + " is not finite";
  for (size_t i = 0; i < model.uvs.size(); ++i)
    if (!is_finite(model.uvs[i])) return "UV " + std::to_string(i) + " is not finite";
  for (size_t i = 0; i < model.triangles.size(); ++i) {
    const ModelTriangle& triangle = model.triangles[i];
    const std::string place = "triangle " + std::to_string(i) + " has ";
    for (int c = 0; c < 3; ++c) {
      if (triangle.position[c] >= model.positions_cm.size())
        return place + "position index " + std::to_string(triangle.position[c]) + " of " +
               std::to_string(model.positions_cm.size());
      if (triangle.uv[c] >= model.uvs.size())
        return place + "UV index " + std::to_string(triangle.uv[c]) + " of " +
               std::to_string(model.uvs.size());
    }
    if (triangle.set >= set_count)
      return place + "texture set " + std::to_string(triangle.set) + " of " + std::to_string(set_count);
    if (triangle.material_class >= kClassCount)
      return place + "class " + std::to_string(triangle.material_class) + " of " +
             std::to_string(kClassCount);
  }
  return "";
}

}  // namespace ohb
