#include "bake/source_surface.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <new>
#include <stdexcept>
#include <string>

#include "bake/jobs.h"
#include "dataset/model/error.h"
#include "dataset/surface/texel_coverage.h"

namespace ohb::bake {
namespace {

bool has_picture(const ScanMaterial& material) {
  return !material.diffuse.empty() || !material.alpha.empty() || !material.normal.empty();
}

/// The scan as a mesh in the model's frame; a texture set a material.
Model mesh_of(const Scan& scan, double unit_cm, Vec3f shift_cm) {
  Model mesh;
  mesh.positions_cm.reserve(scan.positions.size());
  for (const Vec3f& p : scan.positions)
    mesh.positions_cm.push_back({static_cast<float>(p.x * unit_cm + shift_cm.x),
                                 static_cast<float>(p.y * unit_cm + shift_cm.y),
                                 static_cast<float>(p.z * unit_cm + shift_cm.z)});
  mesh.uvs = scan.uvs;
  mesh.uvs.push_back({0, 0});  // of corners without
  const uint32_t no_uv = static_cast<uint32_t>(mesh.uvs.size() - 1);
  for (const ScanTriangle& triangle : triangulate(scan)) {
    ModelTriangle out{};
    for (int c = 0; c < 3; ++c) {
      const Corner& corner = scan.corners[triangle.corner[c]];
      if (corner.uv == Corner::kNoUv && has_picture(scan.materials[scan.face_material[triangle.face]]))
        throw InputError(scan.file.string(), "face " + std::to_string(triangle.face),
                         "has a picture and no UV coordinates",
                         "unwrap the source, or leave its picture out");
      out.position[c] = corner.position;
      out.uv[c] = corner.uv == Corner::kNoUv ? no_uv : corner.uv;
    }
    out.set = scan.face_material[triangle.face];
    out.source_face = triangle.face;
    mesh.triangles.push_back(out);
  }
  return mesh;
}

bool is_sliver(Vec3f a, Vec3f b, Vec3f c) {
  constexpr float kSliver = 1e-4f;  // height over length; positions have 24 bits, some of them for the place
  const Vec3f ab = b - a, ac = c - a, bc = c - b;
  const float squared_length = std::max({dot(ab, ab), dot(ac, ac), dot(bc, bc)});
  return !(length(cross(ab, ac)) > kSliver * squared_length);
}

/// The pixels of a picture that the faces of a material show.
std::vector<uint8_t> shown_pixels(const Model& mesh, uint16_t material, const Image& picture) {
  std::vector<surface::UvTriangle> uvs;
  for (const ModelTriangle& triangle : mesh.triangles) {
    if (triangle.set != material) continue;
    const surface::UvTriangle uv{
        {mesh.uvs[triangle.uv[0]], mesh.uvs[triangle.uv[1]], mesh.uvs[triangle.uv[2]]}};
    for (const Vec2f& corner : uv.uv)
      if (!(std::fabs(corner.x) <= surface::kMaxUvSpan / 2 && std::fabs(corner.y) <= surface::kMaxUvSpan / 2))
        return {};
    uvs.push_back(uv);
  }
  const surface::TexelCoverage coverage = surface::cover_texels(uvs, picture.width_px, picture.height_px);
  std::vector<uint8_t> is_shown(coverage.owner.size());
  for (size_t i = 0; i < is_shown.size(); ++i)
    is_shown[i] = coverage.owner[i] != surface::TexelCoverage::kNone;
  return is_shown;
}

/// The point of a triangle that moves by `step` in 3-D, in UV. Edges and their cross product are given.
struct UvMotion {
  Vec3f edge1, edge2, normal;
  float inverse_squared_area;
  Vec2f uv1, uv2;
  Vec3f direction;
  float along;  // dot(normal, direction), kept away from 0

  Vec2f uv_step(Vec3f step) const {
    const Vec3f in_plane = step - direction * (dot(normal, step) / along);
    const float u = dot(cross(in_plane, edge2), normal) * inverse_squared_area;
    const float v = dot(cross(edge1, in_plane), normal) * inverse_squared_area;
    return u * uv1 + v * uv2;
  }
};

/// Rays that graze the source would smear: no texel covers more than this times what it would head on.
constexpr float kLongestStretch = 8;

}  // namespace

SourceSurface::SourceSurface(const Scan& scan, double unit_cm, Vec3f shift_cm,
                             const std::vector<surface::GreenChannel>& green) {
  const Model mesh = mesh_of(scan, unit_cm, shift_cm);
  bounds_ = bounds_of(mesh.positions_cm);
  positions_ = mesh.positions_cm;
  positions_.push_back({});
  indices_.reserve(3 * mesh.triangles.size());
  for (const ModelTriangle& triangle : mesh.triangles)
    indices_.insert(indices_.end(), std::begin(triangle.position), std::end(triangle.position));
  std::vector<Vec3f> normals;
  if (!scan.corner_colours.empty())
    for (const ScanTriangle& triangle : triangulate(scan))
      for (uint32_t corner : triangle.corner) colours_.push_back(scan.corner_colours[corner]);
  run_side_by_side(
      {[&] { read_materials(scan, mesh, green); },
       [&] {
         normals = smooth_normals(mesh);
         set_triangles(mesh, normals);
         tree_ = surface::TriangleTree(positions_, indices_.data(), triangles_.size(), {true, false});
       }});
  if (std::any_of(materials_.begin(), materials_.end(),
                  [](const SourceMaterial& material) { return !material.normal.empty(); }))
    tangents_ = mikktspace_tangents(mesh, normals);
}

void SourceSurface::set_triangles(const Model& mesh, const std::vector<Vec3f>& normals) {
  triangles_.resize(mesh.triangles.size());
  tbb::parallel_for(size_t{0}, triangles_.size(), [&](size_t t) {
    const ModelTriangle& triangle = mesh.triangles[t];
    SourceTriangle& out = triangles_[t];
    for (int c = 0; c < 3; ++c) {
      out.normal[c] = normals[triangle.position[c]];
      out.uv[c] = mesh.uvs[triangle.uv[c]];
    }
    out.material = triangle.set;
    out.is_sliver =
        is_sliver(mesh.positions_cm[triangle.position[0]], mesh.positions_cm[triangle.position[1]],
                  mesh.positions_cm[triangle.position[2]]);
  });
}

void SourceSurface::read_materials(const Scan& scan, const Model& mesh,
                                   const std::vector<surface::GreenChannel>& green) {
  const auto texture = [&](uint16_t m, Image picture) {
    picture_edge_px_ = std::max({picture_edge_px_, picture.width_px, picture.height_px});
    std::vector<uint8_t> is_shown = shown_pixels(mesh, m, picture);
    return MipTexture(std::move(picture), std::move(is_shown));
  };
  materials_.resize(scan.materials.size());
  for (size_t i = 0; i < materials_.size(); ++i) {
    const auto m = static_cast<uint16_t>(i);
    const ScanMaterial& from = scan.materials[m];
    materials_[m].from = from;
    if (!from.diffuse.empty()) materials_[m].albedo = texture(m, surface::read_colour_picture(from.diffuse));
    if (!from.alpha.empty()) materials_[m].alpha = texture(m, surface::read_alpha_picture(from));
    has_alpha_ = has_alpha_ || !from.is_opaque();
    if (from.normal.empty()) continue;
    uint64_t zero_length = 0;
    const bool is_down = !green.empty() && green[m] == surface::GreenChannel::kDown;
    materials_[m].normal = texture(m, surface::read_normal_picture(from.normal, is_down, zero_length));
  }
}

Vec3f SourceSurface::area_normal(uint32_t triangle) const {
  const uint32_t* const i = &indices_[3 * size_t{triangle}];
  return cross(positions_[i[1]] - positions_[i[0]], positions_[i[2]] - positions_[i[0]]);
}

Vec3f SourceSurface::position(uint32_t triangle, float u, float v) const {
  const uint32_t* const i = &indices_[3 * size_t{triangle}];
  return (1 - u - v) * positions_[i[0]] + u * positions_[i[1]] + v * positions_[i[2]];
}

Vec3f SourceSurface::nearest_point(uint32_t triangle, Vec3f p, float& u, float& v) const {
  // Ericson, "Real-Time Collision Detection" (2005), section 5.1.5: by the region that p lies in.
  const uint32_t* const i = &indices_[3 * size_t{triangle}];
  const Vec3f a = positions_[i[0]], ab = positions_[i[1]] - a, ac = positions_[i[2]] - a, ap = p - a;
  const float d1 = dot(ab, ap), d2 = dot(ac, ap);
  const Vec3f bp = ap - ab, cp = ap - ac;
  const float d3 = dot(ab, bp), d4 = dot(ac, bp), d5 = dot(ab, cp), d6 = dot(ac, cp);
  const float va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
  u = v = 0;
  if (d1 <= 0 && d2 <= 0) {
    // corner a
  } else if (d3 >= 0 && d4 <= d3) {
    u = 1;
  } else if (d6 >= 0 && d5 <= d6) {
    v = 1;
  } else if (vc <= 0 && d1 >= 0 && d3 <= 0) {
    u = d1 / (d1 - d3);
  } else if (vb <= 0 && d2 >= 0 && d6 <= 0) {
    v = d2 / (d2 - d6);
  } else if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    v = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    u = 1 - v;
  } else {
    const float sum = va + vb + vc;
    u = vb / sum;
    v = vc / sum;
  }
  return a + u * ab + v * ac;
}

/// Where the steps `across` and `up` lead in the picture when they are carried along `direction`.
UvFootprint SourceSurface::footprint_of(uint32_t index, Vec3f across, Vec3f up, Vec3f direction) const {
  const SourceTriangle& triangle = triangles_[index];
  const uint32_t* const i = &indices_[3 * size_t{index}];
  UvMotion motion;
  motion.edge1 = positions_[i[1]] - positions_[i[0]];
  motion.edge2 = positions_[i[2]] - positions_[i[0]];
  motion.normal = cross(motion.edge1, motion.edge2);
  const float squared = dot(motion.normal, motion.normal);
  motion.inverse_squared_area = squared > 0 ? 1 / squared : 0;
  motion.uv1 = triangle.uv[1] - triangle.uv[0];
  motion.uv2 = triangle.uv[2] - triangle.uv[0];
  motion.direction = direction;
  const float least = std::sqrt(squared) / kLongestStretch;
  const float along = dot(motion.normal, direction);
  motion.along = squared > 0 ? std::copysign(std::max(std::fabs(along), least), along) : 1;
  return {motion.uv_step(across), motion.uv_step(up)};
}

Vec3f SourceSurface::mapped_normal(uint32_t index, float u, float v, Vec3f normal, const float* n) const {
  const float w = 1 - u - v;
  const CornerTangent* const t = &tangents_[3 * size_t{index}];
  const Vec3f tangent = w * t[0].tangent + u * t[1].tangent + v * t[2].tangent;
  const float sign = w * t[0].sign + u * t[1].sign + v * t[2].sign;
  const Vec3f mapped = n[0] * tangent + n[1] * sign * cross(normal, tangent) + n[2] * normal;
  return dot(mapped, mapped) > 0 ? mapped : normal;
}

SourceSample SourceSurface::sample(uint32_t index, float u, float v, Vec3f across, Vec3f up,
                                   Vec3f direction) const {
  const SourceTriangle& triangle = triangles_[index];
  const SourceMaterial& material = materials_[triangle.material];
  const float w = 1 - u - v;
  Vec3f normal = w * triangle.normal[0] + u * triangle.normal[1] + v * triangle.normal[2];
  SourceSample sample{material.from.diffuse_factor, normal, 1};
  const bool has_normal_map = !material.normal.empty();
  if (!material.albedo.empty() || !material.alpha.empty() || has_normal_map) {
    const UvFootprint footprint = footprint_of(index, across, up, direction);
    const Vec2f uv = w * triangle.uv[0] + u * triangle.uv[1] + v * triangle.uv[2];
    if (!material.albedo.empty()) {
      float rgb[3];
      material.albedo.sample(uv, footprint, rgb);
      sample.albedo = sample.albedo * Vec3f{rgb[0], rgb[1], rgb[2]};
    }
    if (!material.alpha.empty()) material.alpha.sample(uv, footprint, &sample.alpha);
    if (has_normal_map) {
      float n[3];
      material.normal.sample(uv, footprint, n);
      normal = mapped_normal(index, u, v, normal, n);
    }
  }
  if (!colours_.empty()) {
    const VertexColour* const c = &colours_[3 * size_t{index}];
    sample.albedo = sample.albedo * (w * c[0].rgb + u * c[1].rgb + v * c[2].rgb);
    sample.alpha *= w * c[0].alpha + u * c[1].alpha + v * c[2].alpha;
  }
  sample.alpha = material.from.opacity_of(sample.alpha);
  const float squared = dot(normal, normal);
  sample.normal = squared > 0 ? normal / std::sqrt(squared) : normalised(area_normal(index));
  return sample;
}

}  // namespace ohb::bake
