// What differs between Embree 3 and 4 (no other file includes their headers).
#pragma once

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#define OHB_EMBREE 4
#else
#include <embree3/rtcore.h>
#define OHB_EMBREE 3
#endif

namespace ohb {

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

/// Closest hits of up to eight rays that run alike; lanes with valid 0 are left alone, -1 are traced.
inline void intersect_eight(RTCScene scene, const int* valid, RTCRayHit8& ray_hits) {
#if OHB_EMBREE == 4
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  rtcIntersect8(valid, scene, &ray_hits, &arguments);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
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

}  // namespace ohb
