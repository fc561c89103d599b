#include "bake/source_rays.h"

#include <algorithm>
#include <cmath>

namespace ohb::bake {
namespace {

// As the renderer's: 32 units in the last place of the largest coordinate (5 micrometres on a human) clear
// the error of a point that was interpolated on the very surface that the ray looks for.
constexpr float kStartUlps = 32;
/// Back faces nearer than this many starts are at the point itself.
constexpr float kCoincidentStarts = 4;
constexpr int kMostCoincident = 4;
constexpr float kNearestCosine = 0.5f;

float start_of(const SourceSurface& source) {
  const Bounds& b = source.bounds();
  float largest = 0;
  for (int i = 0; i < 3; ++i) largest = std::max({largest, std::fabs(b.low[i]), std::fabs(b.high[i])});
  return kStartUlps * (std::nextafter(largest, INFINITY) - largest);
}

/// What one way found: a point that faces outwards (kHit), a face that ends it (kBackFace), or nothing.
struct Way {
  RayResult result = RayResult::kMissed;
  uint32_t triangle = 0;
  float u = 0, v = 0, t = INFINITY;
};

struct NearestQuery {
  const SourceSurface* source;
  Vec3f origin, direction;
  SourcePoint found;
};

bool visit_nearest(RTCPointQueryFunctionArguments* arguments) {
  NearestQuery& query = *static_cast<NearestQuery*>(arguments->userPtr);
  float u, v;
  const Vec3f nearest = query.source->nearest_point(arguments->primID, query.origin, u, v);
  const Vec3f normal =
      query.source->side_normal(arguments->primID, query.source->area_normal(arguments->primID), u, v);
  if (!(dot(normal, query.direction) > kNearestCosine * length(normal))) return false;
  const Vec3f apart = nearest - query.origin;
  const float distance = length(apart);
  if (distance >= arguments->query->radius) return false;
  arguments->query->radius = distance;
  query.found = {RayResult::kNearest, arguments->primID, u, v, dot(apart, query.direction)};
  return true;
}

/// Whether nothing lies between two points of space. Of the way, the last part is left out: it ends on a
/// surface.
bool sees(const SourceSurface& source, Vec3f from, Vec3f to, float start) {
  const float distance = length(to - from);
  if (!(distance > 2 * start)) return true;
  const Vec3f d = (to - from) / distance;
  RTCRay r{from.x, from.y, from.z, start, d.x, d.y, d.z, 0, distance - start, 0xffffffffu, 0, 0};
  surface::occluded_one(source.bvh(), r);
  return r.tfar >= 0;
}

/// A point of the low mesh that looks for the source along its normal, both ways.
struct Seeker {
  Vec3f origin, outwards;
  float reach_cm;  // in which the nearest point counts where no ray finds one
};

/// Keeps `otherwise` if nothing is within the reach, or something lies before it.
SourcePoint nearest_source(const SourceSurface& source, const Seeker& from, float start,
                           SourcePoint otherwise) {
  const Vec3f origin = from.origin;
  NearestQuery query{&source, origin, from.outwards, otherwise};
  RTCPointQuery point{origin.x, origin.y, origin.z, 0, from.reach_cm};
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(source.bvh(), &point, &context, visit_nearest, &query);
  if (query.found.result != RayResult::kNearest) return otherwise;
  const Vec3f at = source.position(query.found.triangle, query.found.u, query.found.v);
  return sees(source, origin, at, start) ? query.found : otherwise;
}

SourcePoint choose(const SourceSurface& source, const Way& outward, const Way& inward, const Seeker& from,
                   float start) {
  const bool is_out = outward.result == RayResult::kHit, is_in = inward.result == RayResult::kHit;
  if (is_out && (!is_in || outward.t <= inward.t))
    return {RayResult::kHit, outward.triangle, outward.u, outward.v, outward.t};
  if (is_in) return {RayResult::kHit, inward.triangle, inward.u, inward.v, -inward.t};
  SourcePoint none;
  if (outward.result == RayResult::kBackFace || inward.result == RayResult::kBackFace)
    none.result = RayResult::kBackFace;
  return nearest_source(source, from, start, none);
}

/// What a ray of one way met.
struct LayerHit {
  uint32_t triangle;
  Vec3f geometric;  // normal, as Embree has it
  float u, v, t;
};

/// One way of one point: the layers that it passed, and what it found.
class Passage {
 public:
  /// Whether the way goes on behind a hit, from t_near() on; what it says otherwise is in `way`.
  bool goes_on(const SourceSurface& source, const LayerHit& hit, Vec3f outwards, float start, Way& way) {
    const auto& [triangle, geometric, u, v, t] = hit;
    // As beyond says: the layer passed last may be reported again.
    const bool is_met_again = triangle == passed_;
    if (!is_met_again) {
      const bool faces_outwards = dot(source.side_normal(triangle, geometric, u, v), outwards) > 0;
      way = {faces_outwards ? RayResult::kHit : RayResult::kBackFace, triangle, u, v,
             std::max(0.0f, t - start)};
      if (faces_outwards || t > kCoincidentStarts * start || layers_++ == kMostCoincident) return false;
    }
    passed_ = triangle;
    t_near_ = surface::beyond(t, t_near_);
    return true;
  }
  float t_near() const { return t_near_; }

 private:
  uint32_t passed_ = surface::kNoTriangle;
  int layers_ = 0;
  float t_near_ = 0;
};

/// `sign` +1 goes outwards, -1 inwards.
void trace_eight(const SourceSurface& source, const RayPacket& packet, float sign, const float* limit_cm,
                 float start, Way* ways) {
  alignas(32) int valid[RayPacket::kSize];
  alignas(32) RTCRayHit8 r;
  for (int i = 0; i < RayPacket::kSize; ++i) {
    valid[i] = i < packet.count ? -1 : 0;
    const Vec3f d = sign * packet.direction[i], o = packet.origin[i] - start * d;
    r.ray.org_x[i] = o.x, r.ray.org_y[i] = o.y, r.ray.org_z[i] = o.z;
    r.ray.dir_x[i] = d.x, r.ray.dir_y[i] = d.y, r.ray.dir_z[i] = d.z;
    r.ray.tnear[i] = 0, r.ray.tfar[i] = limit_cm[i] + start, r.ray.time[i] = 0;
    r.ray.mask[i] = 0xffffffffu, r.ray.id[i] = 0, r.ray.flags[i] = 0;
    r.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID, r.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
  }
  Passage passages[RayPacket::kSize];
  for (bool any = true; any;) {
    surface::intersect_eight(source.bvh(), valid, r, true);
    any = false;
    for (int i = 0; i < packet.count; ++i) {
      if (!valid[i]) continue;
      valid[i] = 0;
      if (r.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
      const LayerHit hit{r.hit.primID[i],
                         {r.hit.Ng_x[i], r.hit.Ng_y[i], r.hit.Ng_z[i]},
                         r.hit.u[i],
                         r.hit.v[i],
                         r.ray.tfar[i]};
      if (!passages[i].goes_on(source, hit, packet.direction[i], start, ways[i])) continue;
      valid[i] = -1;
      any = true;
      r.ray.tnear[i] = passages[i].t_near();
      r.ray.tfar[i] = limit_cm[i] + start;
      r.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    }
  }
}

Way trace_one(const SourceSurface& source, Vec3f origin, Vec3f outwards, float sign, float limit_cm,
              float start) {
  Way way;
  const Vec3f d = sign * outwards, o = origin - start * d;
  Passage passage;
  for (;;) {
    RTCRayHit r;
    r.ray.org_x = o.x, r.ray.org_y = o.y, r.ray.org_z = o.z;
    r.ray.dir_x = d.x, r.ray.dir_y = d.y, r.ray.dir_z = d.z;
    r.ray.tnear = passage.t_near(), r.ray.tfar = limit_cm + start, r.ray.time = 0;
    r.ray.mask = 0xffffffffu, r.ray.id = 0, r.ray.flags = 0;
    r.hit.geomID = RTC_INVALID_GEOMETRY_ID, r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    surface::intersect_one(source.bvh(), r);
    if (r.hit.geomID == RTC_INVALID_GEOMETRY_ID) break;
    const LayerHit hit{r.hit.primID, {r.hit.Ng_x, r.hit.Ng_y, r.hit.Ng_z}, r.hit.u, r.hit.v, r.ray.tfar};
    if (!passage.goes_on(source, hit, outwards, start, way)) break;
  }
  return way;
}

}  // namespace

void find_source(const SourceSurface& source, const RayPacket& packet, SourcePoint* points) {
  const float start = start_of(source);
  Way outward[RayPacket::kSize], inward[RayPacket::kSize];
  trace_eight(source, packet, 1, packet.outward_cm, start, outward);
  float inward_cm[RayPacket::kSize];
  for (int i = 0; i < RayPacket::kSize; ++i)
    inward_cm[i] = i < packet.count && outward[i].result == RayResult::kHit
                       ? std::min(packet.inward_cm, outward[i].t)
                       : packet.inward_cm;
  trace_eight(source, packet, -1, inward_cm, start, inward);
  for (int i = 0; i < packet.count; ++i)
    points[i] = choose(
        source, outward[i], inward[i],
        {packet.origin[i], packet.direction[i], std::max(packet.outward_cm[i], packet.inward_cm)}, start);
}

SourcePoint find_source_of_one(const SourceSurface& source, Vec3f origin, Vec3f direction, float outward_cm,
                               float inward_cm) {
  const float start = start_of(source);
  const Way outward = trace_one(source, origin, direction, 1, outward_cm, start);
  const bool is_out = outward.result == RayResult::kHit;
  const Way inward =
      trace_one(source, origin, direction, -1, is_out ? std::min(inward_cm, outward.t) : inward_cm, start);
  return choose(source, outward, inward, {origin, direction, std::max(outward_cm, inward_cm)}, start);
}

}  // namespace ohb::bake
