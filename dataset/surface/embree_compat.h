// Embree: what differs between its versions 3 and 4 (no other file includes their headers), and how a ray
// goes on behind a hit.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#define OHB_EMBREE 4
#else
#include <embree3/rtcore.h>
#define OHB_EMBREE 3
#endif

namespace ohb::surface {

/// Closest hit of one ray; ray_hit.hit.geomID stays RTC_INVALID_GEOMETRY_ID if there is none.
inline void intersect_one(RTCScene scene, RTCRayHit& ray_hit) {
#if OHB_EMBREE == 4
  rtcIntersect1(scene, &ray_hit);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, &ray_hit);
#endif
}

/// Closest hits of up to eight rays; lanes with valid 0 are left alone, -1 are traced. Faster for rays of a
/// camera if it is told that they run alike.
inline void intersect_eight(RTCScene scene, const int* valid, RTCRayHit8& ray_hits, bool run_alike) {
#if OHB_EMBREE == 4
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  if (run_alike) arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  rtcIntersect8(valid, scene, &ray_hits, &arguments);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  if (run_alike) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect8(valid, scene, &context, &ray_hits);
#endif
}

/// Any hit of up to eight rays; lanes as above, tfar as below.
inline void occluded_eight(RTCScene scene, const int* valid, RTCRay8& rays) {
#if OHB_EMBREE == 4
  rtcOccluded8(valid, scene, &rays);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded8(valid, scene, &context, &rays);
#endif
}

#if OHB_EMBREE == 4
using QueryContext = RTCRayQueryContext;
#else
using QueryContext = RTCIntersectContext;
#endif

/// Lets queries of the scene, which is not committed yet, have filters.
inline void allow_filters(RTCScene scene, [[maybe_unused]] RTCGeometry geometry) {
#if OHB_EMBREE == 4
  rtcSetGeometryEnableFilterFunctionFromArguments(geometry, true);
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS);
#else
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
#endif
}

/// Any hit of up to eight rays that the filter lets stand. It is asked about each triangle that a ray meets,
/// once and in any order, and gets `context`, which may be the first member of what it needs.
inline void occluded_eight(RTCScene scene, const int* valid, RTCRay8& rays, RTCFilterFunctionN filter,
                           QueryContext& context) {
#if OHB_EMBREE == 4
  rtcInitRayQueryContext(&context);
  RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  arguments.context = &context;
  arguments.filter = filter;
  rtcOccluded8(valid, scene, &rays, &arguments);
#else
  rtcInitIntersectContext(&context);
  context.filter = filter;
  rtcOccluded8(valid, scene, &context, &rays);
#endif
}

/// Any hit; ray.tfar becomes negative infinity if there is one.
inline void occluded_one(RTCScene scene, RTCRay& ray) {
#if OHB_EMBREE == 4
  rtcOccluded1(scene, &ray);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene, &context, &ray);
#endif
}

/// Where a ray that passes a hit at t goes on. Embree compares with a distance before its last rounding: from
/// the next number on it may report the same hit again (one in a thousand), for ever if the ray does not move
/// on. So this moves at each call, over subnormal numbers too, which count as 0; who counts hits must leave
/// out those of the triangle passed last.
inline float beyond(float t, float t_near) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  return std::fmax(std::nextafter(std::fmax(t, t_near), kInfinity), std::numeric_limits<float>::min());
}
constexpr uint32_t kNoTriangle = 0xffffffffu;

}  // namespace ohb::surface
