// From a hit to what shading needs: position, the three normals and the material.
#pragma once

#include <array>
#include <cmath>
#include <type_traits>

#include "dataset/model/colour.h"
#include "renderer/bsdf_v2.h"
#include "renderer/intersect.h"

namespace ohb::renderer {

struct SurfacePoint {
  Hit hit;
  Vec3f position;   // cm, subject frame
  Vec3f ng, ns, n;  // geometric, smooth and mapped normal, unit, on the side of wo
  SurfaceTexel texel;
  uint8_t material_class;
  bool has_normal_map;
};

inline Vec3f position_at(const Scene& scene, const Hit& hit) {
  const uint32_t* i = &scene.indices[3 * size_t{hit.triangle}];
  return (1 - hit.u - hit.v) * scene.positions[i[0]] + hit.u * scene.positions[i[1]] +
         hit.v * scene.positions[i[2]];
}

inline Vec3f geometric_normal(const Scene& scene, uint32_t triangle) {
  const uint32_t* i = &scene.indices[3 * size_t{triangle}];
  const Vec3f p0 = scene.positions[i[0]];
  return normalised(cross(scene.positions[i[1]] - p0, scene.positions[i[2]] - p0));
}

/// The mapped normal before it is turned to the viewer: T, B and N are interpolated and not normalised, as
/// MikkTSpace wants it. Falls back to the smooth normal where the map gives no direction.
inline Vec3f mapped_normal(const Scene& scene, const Hit& hit, Vec2f uv, Vec3f smooth_unnormalised,
                           Vec3f ns) {
  const TriangleTangents& tangents = scene.tangents[hit.triangle];
  const float w = 1 - hit.u - hit.v;
  const Vec3f t = w * tangents.tangent[0] + hit.u * tangents.tangent[1] + hit.v * tangents.tangent[2];
  const float sign = w * tangents.sign[0] + hit.u * tangents.sign[1] + hit.v * tangents.sign[2];
  const Vec3f c = scene.sets[scene.attributes[hit.triangle].set].normal(uv);
  const Vec3f n = c.x * t + c.y * sign * cross(smooth_unnormalised, t) + c.z * smooth_unnormalised;
  const float squared = dot(n, n);
  return squared > 0 && std::isfinite(squared) ? n / std::sqrt(squared) : ns;
}

inline SurfacePoint surface_at(const Scene& scene, const Hit& hit, Vec3f wo) {
  const TriangleAttributes& a = scene.attributes[hit.triangle];
  SurfacePoint point;
  point.hit = hit;
  point.position = position_at(scene, hit);
  point.ng = geometric_normal(scene, hit.triangle);
  const Vec3f smooth = (1 - hit.u - hit.v) * a.normal[0] + hit.u * a.normal[1] + hit.v * a.normal[2];
  const float squared = dot(smooth, smooth);
  point.ns = squared > 0 ? smooth / std::sqrt(squared) : point.ng;
  const Vec2f uv = uv_at(scene, hit);
  point.texel = scene.sets[a.set].surface(uv);
  point.n = a.has_normal_map ? mapped_normal(scene, hit, uv, smooth, point.ns) : point.ns;
  point.material_class = a.material_class;
  point.has_normal_map = a.has_normal_map;
  if (dot(point.ng, wo) < 0) {
    point.ng = -point.ng;
    point.ns = -point.ns;
    point.n = -point.n;
  }
  return point;
}

/// Where a ray that leaves `position` towards `direction` starts: on the side of the surface that it goes to.
inline Vec3f ray_origin(const Scene& scene, Vec3f position, Vec3f ng, Vec3f direction) {
  return position + (dot(ng, direction) >= 0 ? scene.self_hit_offset_cm : -scene.self_hit_offset_cm) * ng;
}

/// What the subsurface of a point does to a path: nothing; it has come by a diffuse bounce, after which walks
/// are not made; a walk.
enum class UnderSurface { kNone, kDiffuse, kWalk };

/// The BSDF of a point seen from wo.
template <class Bsdf>
Bsdf bsdf_at(const SurfacePoint& point, Vec3f wo, bool first_hit, UnderSurface under) {
  const Vec3f n = cycles::ensure_valid_reflection(point.ng, wo, point.n);
  const SurfaceTexel& texel = point.texel;
  const float f0 = srgb_to_linear(texel.specular);
  const Reflectance surface{texel.albedo, texel.roughness, f0};
  if constexpr (std::is_same_v<Bsdf, PrincipledV1>) {
    return Bsdf(surface, {n, point.ns, point.ng, wo}, first_hit,
                under == UnderSurface::kWalk ? DiffuseLobe::kRetroReflection : DiffuseLobe::kWhole);
  } else {
    return Bsdf(surface, {under == UnderSurface::kNone ? 0.0f : 1.0f, under == UnderSurface::kWalk},
                {point.n, point.ns, point.ng, wo}, n, first_hit);
  }
}

/// The end of a walk under the surface. Where the surface that it comes out at has no subsurface, its normal
/// map is not asked (Cycles weights the normals of the lobes that enter there, of which there are none); and
/// without a map the smooth normal is taken as it is.
template <class Bsdf>
Bsdf exit_bsdf_at(const SurfacePoint& point, Vec3f wo) {
  const bool has_map = point.has_normal_map && point.texel.sss > cycles::kLeastSubsurface;
  const Vec3f n = has_map ? cycles::ensure_valid_reflection(point.ng, wo, point.n) : point.ns;
  constexpr Reflectance kWhite{{1, 1, 1}, 1, 0};
  if constexpr (std::is_same_v<Bsdf, PrincipledV1>)
    return Bsdf(kWhite, {n, point.ns, point.ng, wo}, false, DiffuseLobe::kExit);
  else
    return Bsdf(kWhite, {}, {n, point.ns, point.ng, wo}, n, false);
}

/// The pinhole camera in the subject's frame: the subject turns by an angle, so the camera turns back.
class ViewCamera {
 public:
  ViewCamera(const Camera& camera, double turn_rad, int size_px)
      : origin_(turn_about_y({0, camera.center_y_cm, camera.distance_cm}, -turn_rad)),
        right_(turn_about_y({1, 0, 0}, -turn_rad)),
        forward_(turn_about_y({0, 0, -1}, -turn_rad)),
        scale_(2 * camera.half_width / static_cast<float>(size_px)),
        half_width_(camera.half_width) {}
  /// Ray through image coordinates in pixels, (0, 0) the top left corner.
  Ray ray(float x_px, float y_px) const {
    const float x = x_px * scale_ - half_width_, y = half_width_ - y_px * scale_;
    return {origin_, normalised(x * right_ + Vec3f{0, y, 0} + forward_)};
  }
  /// Image coordinates in pixels of a point of the subject's frame; false if it is not well before the
  /// camera.
  bool project(Vec3f position, Vec2f& image_px) const {
    const Vec3f to_point = position - origin_;
    const float depth = dot(to_point, forward_);
    if (!(depth > 1e-3f * length(to_point))) return false;
    image_px = {(dot(to_point, right_) / depth + half_width_) / scale_,
                (half_width_ - to_point.y / depth) / scale_};
    return true;
  }
  /// Camera-space coordinates (+X right, +Y up, +Z to the viewer) of a direction of the subject's frame.
  Vec3f to_camera(Vec3f v) const { return {dot(v, right_), v.y, -dot(v, forward_)}; }

 private:
  Vec3f origin_, right_, forward_;
  float scale_, half_width_;
};

}  // namespace ohb::renderer
