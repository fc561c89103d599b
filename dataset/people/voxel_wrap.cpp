#include "dataset/people/voxel_wrap.h"

#include <algorithm>
#include <cmath>

#include "dataset/model/error.h"

namespace ohb::people {
namespace {

constexpr size_t kMaxPoints = size_t{64} << 20;
constexpr uint32_t kNone = 0xffffffffu;

/// Distances at the points of a regular grid, negative in what is solid.
class Grid {
 public:
  Grid(const std::vector<Vec3f>& positions, const std::vector<SurfaceTriangle>& triangles, float voxel)
      : voxel_(voxel) {
    Vec3f low{INFINITY, INFINITY, INFINITY}, high = -low;
    for (const SurfaceTriangle& triangle : triangles)
      for (const uint32_t corner : triangle.corner)
        for (int a = 0; a < 3; ++a) {
          low[a] = std::min(low[a], positions[corner][a]);
          high[a] = std::max(high[a], positions[corner][a]);
        }
    constexpr float kMargin = 4;
    origin_ = low - kMargin * voxel * Vec3f{1, 1, 1};
    size_t count = 1;
    for (int a = 0; a < 3; ++a) {
      size_[a] = static_cast<int>((high[a] - low[a]) / voxel + 2 * kMargin) + 1;
      count *= static_cast<size_t>(size_[a]);
    }
    if (count > kMaxPoints)
      throw InputError("", "--fused", "the person is too large for the grid", "leave it out");
    distance_.assign(count, 2 * voxel);
    for (const SurfaceTriangle& triangle : triangles) splat(positions, triangle);
    find_solid();
  }

  int size(int axis) const { return size_[axis]; }
  size_t index(int x, int y, int z) const {
    return (static_cast<size_t>(z) * static_cast<size_t>(size_[1]) + static_cast<size_t>(y)) *
               static_cast<size_t>(size_[0]) +
           static_cast<size_t>(x);
  }
  float at(size_t i) const { return distance_[i]; }
  Vec3f place(float x, float y, float z) const { return origin_ + voxel_ * Vec3f{x, y, z}; }

 private:
  void splat(const std::vector<Vec3f>& positions, const SurfaceTriangle& triangle) {
    const Vec3f a = positions[triangle.corner[0]], b = positions[triangle.corner[1]],
                c = positions[triangle.corner[2]];
    int first[3], last[3];
    for (int k = 0; k < 3; ++k) {
      const float low = std::min({a[k], b[k], c[k]}) - 2 * voxel_,
                  high = std::max({a[k], b[k], c[k]}) + 2 * voxel_;
      first[k] = std::max(0, static_cast<int>((low - origin_[k]) / voxel_));
      last[k] = std::min(size_[k] - 1, static_cast<int>((high - origin_[k]) / voxel_) + 1);
    }
    for (int z = first[2]; z <= last[2]; ++z)
      for (int y = first[1]; y <= last[1]; ++y)
        for (int x = first[0]; x <= last[0]; ++x) {
          const Vec3f p = place(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
          float v, w;
          nearest_in_triangle(p, a, b, c, v, w);
          float& distance = distance_[index(x, y, z)];
          distance = std::min(distance, length(p - ((1 - v - w) * a + v * b + w * c)));
        }
  }

  /// Outside is what a flood from the corner reaches without coming nearer than a voxel.
  void find_solid() {
    std::vector<uint8_t> is_outside(distance_.size(), 0);
    std::vector<size_t> queue{0};
    is_outside[0] = 1;
    const size_t row = static_cast<size_t>(size_[0]), layer = row * static_cast<size_t>(size_[1]);
    while (!queue.empty()) {
      const size_t i = queue.back();
      queue.pop_back();
      const size_t x = i % row, y = i / row % static_cast<size_t>(size_[1]), z = i / layer;
      const auto visit = [&](bool exists, size_t next) {
        if (!exists || is_outside[next] || distance_[next] <= voxel_) return;
        is_outside[next] = 1;
        queue.push_back(next);
      };
      visit(x > 0, i - 1), visit(x + 1 < row, i + 1);
      visit(y > 0, i - row), visit(y + 1 < static_cast<size_t>(size_[1]), i + row);
      visit(z > 0, i - layer), visit(z + 1 < static_cast<size_t>(size_[2]), i + layer);
    }
    for (size_t i = 0; i < distance_.size(); ++i) {
      const float from_shell = distance_[i] - voxel_;
      // Never 0, so that each edge of the grid either crosses the surface or does not.
      distance_[i] = is_outside[i] ? std::max(from_shell, 1e-4f) : -std::max(std::fabs(from_shell), 1e-4f);
    }
  }

  float voxel_;
  Vec3f origin_;
  int size_[3] = {};
  std::vector<float> distance_;
};

/// A vertex in each cell that the surface passes, in the middle of its crossings.
std::vector<uint32_t> place_vertices(const Grid& grid, WrappedSurface& surface) {
  std::vector<uint32_t> vertex_of(grid.index(grid.size(0) - 1, grid.size(1) - 1, grid.size(2) - 1) + 1,
                                  kNone);
  for (int z = 0; z + 1 < grid.size(2); ++z)
    for (int y = 0; y + 1 < grid.size(1); ++y)
      for (int x = 0; x + 1 < grid.size(0); ++x) {
        Vec3f sum;
        int crossings = 0;
        for (int corner = 0; corner < 8; ++corner)
          for (int axis = 0; axis < 3; ++axis) {
            if (corner >> axis & 1) continue;
            const int a[3] = {corner & 1, corner >> 1 & 1, corner >> 2 & 1};
            const float from = grid.at(grid.index(x + a[0], y + a[1], z + a[2]));
            const float to =
                grid.at(grid.index(x + a[0] + (axis == 0), y + a[1] + (axis == 1), z + a[2] + (axis == 2)));
            if ((from < 0) == (to < 0)) continue;
            Vec3f at{static_cast<float>(a[0]), static_cast<float>(a[1]), static_cast<float>(a[2])};
            at[axis] += from / (from - to);
            sum += at, ++crossings;
          }
        if (crossings == 0) continue;
        sum *= 1 / static_cast<float>(crossings);
        vertex_of[grid.index(x, y, z)] = static_cast<uint32_t>(surface.positions_cm.size());
        surface.positions_cm.push_back(grid.place(
            static_cast<float>(x) + sum.x, static_cast<float>(y) + sum.y, static_cast<float>(z) + sum.z));
      }
  return vertex_of;
}

}  // namespace

WrappedSurface wrap(const std::vector<Vec3f>& positions_cm, const std::vector<SurfaceTriangle>& triangles,
                    float voxel_cm) {
  const Grid grid(positions_cm, triangles, voxel_cm);
  WrappedSurface surface;
  const std::vector<uint32_t> vertex_of = place_vertices(grid, surface);
  for (int z = 1; z + 1 < grid.size(2); ++z)
    for (int y = 1; y + 1 < grid.size(1); ++y)
      for (int x = 1; x + 1 < grid.size(0); ++x)
        for (int axis = 0; axis < 3; ++axis) {
          const float from = grid.at(grid.index(x, y, z));
          const float to = grid.at(grid.index(x + (axis == 0), y + (axis == 1), z + (axis == 2)));
          if ((from < 0) == (to < 0)) continue;
          // The four cells around the edge, counter-clockwise seen from where it points.
          const int b = (axis + 1) % 3, c = (axis + 2) % 3;
          const auto cell = [&](int db, int dc) {
            int at[3] = {x, y, z};
            at[b] -= db, at[c] -= dc;
            return vertex_of[grid.index(at[0], at[1], at[2])];
          };
          std::array<uint32_t, 4> quad{cell(1, 1), cell(0, 1), cell(0, 0), cell(1, 0)};
          if (!(from < 0)) std::swap(quad[1], quad[3]);
          surface.quads.push_back(quad);
        }
  return surface;
}

}  // namespace ohb::people
