// Geometry as the kernels want it: bounding volume hierarchies, one cache line of attributes a triangle,
// texels. Everything is in the subject's own frame (cm): cameras and lights turn instead of the subject.
#pragma once

#include <cstdint>
#include <vector>

#include "dataset/surface/triangle_tree.h"
#include "renderer/render.h"
#include "renderer/texels.h"

namespace ohb::renderer {

/// Vertex attributes of one triangle; 64 bytes.
struct alignas(64) TriangleAttributes {
  Vec3f normal[3];  // smooth, unit
  Vec2f uv[3];
  uint16_t set;
  uint8_t material_class;
  uint8_t has_normal_map;
};

/// MikkTSpace tangents of one triangle's corners.
struct TriangleTangents {
  Vec3f tangent[3];
  float sign[3];
};

struct Hit {
  uint32_t triangle;  // index into Scene's arrays
  float u, v;         // barycentric weights of corners 1 and 2
  float t;
};

class Scene {
 public:
  explicit Scene(const Model& model);
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  std::vector<Vec3f> positions;   // one more than the model has: Embree reads 16 bytes at the last
  std::vector<uint32_t> indices;  // 3 a triangle; opaque triangles first, then those with a cut-out
  std::vector<TriangleAttributes> attributes;
  std::vector<TriangleTangents> tangents;  // empty if no set has a normal map
  std::vector<Texels> sets;
  Bounds bounds;                                // of all positions
  uint32_t opaque_count = 0;                    // triangles [0, opaque_count) are opaque
  float self_hit_offset_cm = 0;                 // how far a ray starts from the surface that it leaves
  RTCScene opaque = nullptr, cutout = nullptr;  // null if they have no triangle

 private:
  /// In the order of `order`, which numbers the model's triangles.
  void set_triangles(const Model& model, const std::vector<uint32_t>& order);

  surface::TriangleTree opaque_tree_, cutout_tree_;
};

}  // namespace ohb::renderer
