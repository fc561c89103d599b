// Embree's bounding volume hierarchy over the triangles of a mesh.
#pragma once

#include <cstddef>
#include <vector>

#include "dataset/model/vec.h"
#include "dataset/surface/embree_compat.h"

namespace ohb::surface {

struct TreeOptions {
  bool is_robust = false;    // no ray slips between two triangles that share an edge
  bool has_filters = false;  // queries may pass triangles by a filter
};

class TriangleTree {
 public:
  /// Of no triangles: scene() is null.
  TriangleTree() = default;
  /// `corners` holds three indices a triangle, which is how hits number them. Borrows both arrays;
  /// `positions` has one more than are used, since Embree reads 16 bytes at the last. Throws std::bad_alloc,
  /// or std::runtime_error with Embree's words.
  TriangleTree(const std::vector<Vec3f>& positions, const uint32_t* corners, size_t triangle_count,
               TreeOptions options = {});
  ~TriangleTree();
  TriangleTree(TriangleTree&& other) noexcept;
  TriangleTree& operator=(TriangleTree&& other) noexcept;

  RTCScene scene() const { return scene_; }

 private:
  RTCDevice device_ = nullptr;
  RTCScene scene_ = nullptr;
};

}  // namespace ohb::surface
