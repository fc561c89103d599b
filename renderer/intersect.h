// Rays against the scene, with cut-outs passed by chance (closest hit) or by transmittance (shadow rays).
#pragma once

#include <cmath>
#include <limits>
#include <type_traits>

#include "dataset/model/sampling.h"
#include "renderer/scene.h"
#include "renderer/shadow_guess.h"

namespace ohb::renderer {

struct Ray {
  Vec3f origin, direction;  // unit direction, subject frame, cm
};

/// Rays of one tile.
struct RayCounts {
  uint64_t closest_hit = 0, shadow = 0;
  uint64_t walks = 0, walk_segments = 0, walk_leaks = 0;
  /// What was done, counted in rays. Walks go eight at once: a segment is worth a quarter of one (measured).
  double work() const {
    return static_cast<double>(closest_hit + shadow) + 0.25 * static_cast<double>(walk_segments);
  }
  std::vector<RecordedRay>* record = nullptr;
};

inline bool is_within(const Bounds& bounds, Vec3f p) {
  return p.x >= bounds.low.x && p.y >= bounds.low.y && p.z >= bounds.low.z && p.x <= bounds.high.x &&
         p.y <= bounds.high.y && p.z <= bounds.high.z;
}

inline void record_ray(RayCounts& counts, const Ray& ray, float t_near, float t_far, bool is_shadow,
                       bool is_cutout) {
  if (counts.record)
    counts.record->push_back({ray.origin, ray.direction, t_near, t_far, is_shadow, is_cutout});
}

inline RTCRayHit embree_ray(const Ray& ray, float t_near, float t_far) {
  RTCRayHit r;
  r.ray.org_x = ray.origin.x, r.ray.org_y = ray.origin.y, r.ray.org_z = ray.origin.z;
  r.ray.dir_x = ray.direction.x, r.ray.dir_y = ray.direction.y, r.ray.dir_z = ray.direction.z;
  r.ray.tnear = t_near, r.ray.tfar = t_far, r.ray.time = 0;
  r.ray.mask = 0xffffffffu, r.ray.id = 0, r.ray.flags = 0;
  r.hit.geomID = RTC_INVALID_GEOMETRY_ID, r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  return r;
}

/// Closest hit of one bounding volume hierarchy; false if there is none in [t_near, t_far].
inline bool intersect_bvh(RTCScene bvh, uint32_t first_triangle, const Ray& ray, float t_near, float t_far,
                          Hit& hit) {
  RTCRayHit r = embree_ray(ray, t_near, t_far);
  surface::intersect_one(bvh, r);
  if (r.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
  hit = {first_triangle + r.hit.primID, r.hit.u, r.hit.v, r.ray.tfar};
  return true;
}

/// Lane i of Embree's rays from 0 to t_far.
template <class Rays8>
void set_lane(Rays8& rays, int i, const Ray& ray, float t_far) {
  rays.org_x[i] = ray.origin.x, rays.org_y[i] = ray.origin.y, rays.org_z[i] = ray.origin.z;
  rays.dir_x[i] = ray.direction.x, rays.dir_y[i] = ray.direction.y, rays.dir_z[i] = ray.direction.z;
  rays.tnear[i] = 0, rays.tfar[i] = t_far, rays.time[i] = 0;
  rays.mask[i] = 0xffffffffu, rays.id[i] = 0, rays.flags[i] = 0;
}

inline Vec2f uv_at(const Scene& scene, const Hit& hit) {
  const TriangleAttributes& a = scene.attributes[hit.triangle];
  return (1 - hit.u - hit.v) * a.uv[0] + hit.u * a.uv[1] + hit.v * a.uv[2];
}

/// Bring what surface_at will read into the cache: first what hangs on the triangle, then on its UVs.
inline void prefetch_surface(const Scene& scene, const Hit& hit) {
  __builtin_prefetch(&scene.attributes[hit.triangle]);
  __builtin_prefetch(&scene.indices[3 * size_t{hit.triangle}]);
  if (scene.tangents.empty()) return;
  __builtin_prefetch(&scene.tangents[hit.triangle]);
}
inline void prefetch_texels(const Scene& scene, const Hit& hit) {
  const TriangleAttributes& a = scene.attributes[hit.triangle];
  scene.sets[a.set].prefetch(uv_at(scene, hit));
  const uint32_t* corners = &scene.indices[3 * size_t{hit.triangle}];
  for (int c = 0; c < 3; ++c) __builtin_prefetch(&scene.positions[corners[c]]);
}

inline float alpha_at(const Scene& scene, const Hit& hit) {
  return scene.sets[scene.attributes[hit.triangle].set].alpha(uv_at(scene, hit));
}

/// The closest hit that a ray does not pass: each cut-out layer is passed with probability 1 - alpha.
template <bool kCutouts>
bool intersect(const Scene& scene, const Ray& ray, Random& random, RayCounts& counts, Hit& hit) {
  ++counts.closest_hit;
  float t_far = std::numeric_limits<float>::infinity();
  record_ray(counts, ray, 0, t_far, false, false);
  bool found = scene.opaque && intersect_bvh(scene.opaque, 0, ray, 0, t_far, hit);
  if constexpr (kCutouts) {
    if (found) t_far = hit.t;
    float t_near = 0;
    uint32_t passed = surface::kNoTriangle;
    Hit layer;
    record_ray(counts, ray, t_near, t_far, false, true);
    while (intersect_bvh(scene.cutout, scene.opaque_count, ray, t_near, t_far, layer)) {
      const float alpha = layer.triangle == passed ? 0 : alpha_at(scene, layer);
      if (alpha >= 1 || random.next() < alpha) {
        hit = layer;
        return true;
      }
      passed = layer.triangle;
      t_near = surface::beyond(layer.t, t_near);
      ++counts.closest_hit;
      record_ray(counts, ray, t_near, t_far, false, true);
    }
  }
  return found;
}

/// What a ray met.
struct Found {
  bool is_hit;
  Hit hit;
};

/// Closest opaque hits of up to eight rays; `found` may be of a type that is a Found and more. Faster for
/// rays of a camera if it is told that they run alike.
template <class RayOf, class FoundAndMore>
void closest_opaque(const Scene& scene, int count, const RayOf& ray_of, bool run_alike, RayCounts& counts,
                    FoundAndMore* found) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  alignas(32) int valid[8];
  RTCRayHit8 r;
  counts.closest_hit += static_cast<uint64_t>(count);
  for (int i = 0; i < 8; ++i) {
    const Ray& ray = ray_of(i < count ? i : 0);
    valid[i] = i < count ? -1 : 0;
    set_lane(r.ray, i, ray, kInfinity);
    r.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID, r.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    if (i < count) record_ray(counts, ray, 0, kInfinity, false, false);
  }
  if (scene.opaque) surface::intersect_eight(scene.opaque, valid, r, run_alike);
  for (int i = 0; i < count; ++i) {
    found[i].is_hit = r.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
    found[i].hit = {r.hit.primID[i], r.hit.u[i], r.hit.v[i], r.ray.tfar[i]};
  }
}

/// Eight rays through cut-outs.
struct CutoutQuery {
  surface::QueryContext context;  // first: Embree hands it to the filter
  const Scene* scene;
  /// In double: layers come in the order of Embree's tree, which no float should show.
  double light[8] = {1, 1, 1, 1, 1, 1, 1, 1};
};
static_assert(std::is_standard_layout_v<CutoutQuery>);

/// A layer of cut-outs leaves 1 - alpha of a ray's light, whose id is its place in the query.
inline void pass_cutout(const RTCFilterFunctionNArguments* asked) {
  auto& query = *reinterpret_cast<CutoutQuery*>(asked->context);
  for (unsigned int i = 0; i < asked->N; ++i) {
    if (asked->valid[i] != -1) continue;
    const Hit hit{query.scene->opaque_count + RTCHitN_primID(asked->hit, asked->N, i),
                  RTCHitN_u(asked->hit, asked->N, i), RTCHitN_v(asked->hit, asked->N, i), 0};
    double& light = query.light[RTCRayN_id(asked->ray, asked->N, i)];
    light *= 1 - std::fmin(1.0f, alpha_at(*query.scene, hit));
    if (light > 0) asked->valid[i] = 0;
  }
}

/// What a light would bring if nothing stood between: it waits for its shadow ray.
struct WaitingLight {
  Ray ray;
  float t_far;  // cm; infinite for environments
  Vec3f value;
  uint32_t light;
  float expected = 0;          // the share of it that is counted already
  SeenShares* seen = nullptr;  // hears what the ray finds
};

/// Shares of up to eight lights' values that arrive: 0 behind anything opaque.
template <bool kCutouts>
void transmittances(const Scene& scene, const WaitingLight* lights, int count, RayCounts& counts,
                    float* shares) {
  alignas(32) int valid[8];
  RTCRay8 r;
  counts.shadow += static_cast<uint64_t>(count);
  for (int i = 0; i < 8; ++i) {
    const WaitingLight& light = lights[i < count ? i : 0];
    valid[i] = i < count ? -1 : 0;
    set_lane(r, i, light.ray, light.t_far);
    if (i < count) record_ray(counts, light.ray, 0, light.t_far, true, false);
  }
  if (scene.opaque) surface::occluded_eight(scene.opaque, valid, r);
  for (int i = 0; i < count; ++i) shares[i] = r.tfar[i] < 0 ? 0.0f : 1.0f;
  if constexpr (kCutouts) {
    CutoutQuery query;
    query.scene = &scene;
    for (int i = 0; i < count; ++i) {
      r.id[i] = static_cast<unsigned int>(i);
      if (!(shares[i] > 0)) {
        valid[i] = 0;
        continue;
      }
      ++counts.shadow;
      record_ray(counts, lights[i].ray, 0, lights[i].t_far, true, true);
    }
    surface::occluded_eight(scene.cutout, valid, r, pass_cutout, query.context);
    for (int i = 0; i < count; ++i) shares[i] *= static_cast<float>(query.light[i]);
  }
}

}  // namespace ohb::renderer
