// A high-resolution source as the bake's rays find it: triangles in the model's frame (cm), a bounding volume
// hierarchy, smooth normals, and its pictures with their mip levels.
#pragma once

#include <cstdint>
#include <vector>

#include "bake/mip_texture.h"
#include "dataset/model/model.h"
#include "dataset/model/scan.h"
#include "dataset/model/tangent_frame.h"
#include "dataset/surface/picture.h"
#include "dataset/surface/triangle_tree.h"

namespace ohb::bake {

/// What shading needs of a triangle; 64 bytes.
struct alignas(64) SourceTriangle {
  Vec3f normal[3];  // smooth, unit
  Vec2f uv[3];
  uint16_t material;
  bool is_sliver;
};

struct SourceMaterial {
  ScanMaterial from;                 // its factor and opacity
  MipTexture albedo, alpha, normal;  // empty: the factor alone, opaque, smooth normals
};

/// The material values at a point of the source. The normal is a unit vector of the model's frame.
struct SourceSample {
  Vec3f albedo, normal;
  float alpha;
};

class SourceSurface {
 public:
  /// Position in cm = source position x unit_cm + shift_cm. `green`: of each material's normal map; empty:
  /// up. Throws InputError for a picture that cannot be read, and (naming the face) for a face with a picture
  /// and without UVs.
  SourceSurface(const Scan& scan, double unit_cm, Vec3f shift_cm,
                const std::vector<surface::GreenChannel>& green);
  SourceSurface(const SourceSurface&) = delete;
  SourceSurface& operator=(const SourceSurface&) = delete;

  size_t triangle_count() const { return triangles_.size(); }
  RTCScene bvh() const { return tree_.scene(); }
  const Bounds& bounds() const { return bounds_; }
  bool has_alpha() const { return has_alpha_; }
  /// The longest edge of its pictures in pixels; 0 without any.
  int picture_edge_px() const { return picture_edge_px_; }
  /// A triangle's normal by its winding, twice its area long.
  Vec3f area_normal(uint32_t triangle) const;

  Vec3f position(uint32_t triangle, float u, float v) const;
  /// For telling front from back: the geometric normal, not unit; of slivers, whose own winding is rounding,
  /// the smooth normal at u, v.
  Vec3f side_normal(uint32_t triangle, Vec3f geometric, float u, float v) const {
    const SourceTriangle& t = triangles_[triangle];
    if (!t.is_sliver) return geometric;
    return (1 - u - v) * t.normal[0] + u * t.normal[1] + v * t.normal[2];
  }
  /// The point of a triangle nearest to p, and its barycentric weights of corners 1 and 2.
  Vec3f nearest_point(uint32_t triangle, Vec3f p, float& u, float& v) const;

  /// At barycentric weights u, v of corners 1 and 2. `across` and `up` are the steps in cm that one texel of
  /// the map makes on a surface there, `direction` the ray's: the footprint is what they cover when carried
  /// along the ray onto the triangle.
  SourceSample sample(uint32_t triangle, float u, float v, Vec3f across, Vec3f up, Vec3f direction) const;

 private:
  void read_materials(const Scan& scan, const Model& mesh, const std::vector<surface::GreenChannel>& green);
  void set_triangles(const Model& mesh, const std::vector<Vec3f>& normals);
  UvFootprint footprint_of(uint32_t triangle, Vec3f across, Vec3f up, Vec3f direction) const;
  /// The normal map's normal at that point, of any length; `normal` where the map holds no direction.
  Vec3f mapped_normal(uint32_t triangle, float u, float v, Vec3f normal, const float* map) const;

  std::vector<Vec3f> positions_;   // one more than there are: Embree reads 16 bytes at the last
  std::vector<uint32_t> indices_;  // 3 a triangle
  std::vector<SourceTriangle> triangles_;
  std::vector<CornerTangent> tangents_;  // 3 a triangle; empty without normal maps
  std::vector<VertexColour> colours_;    // 3 a triangle; empty without colours at vertices
  std::vector<SourceMaterial> materials_;
  Bounds bounds_;
  bool has_alpha_ = false;
  int picture_edge_px_ = 0;
  surface::TriangleTree tree_;
};

}  // namespace ohb::bake
