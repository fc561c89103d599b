#include "dataset/people/surface_query.h"

namespace ohb::people {

SurfaceQuery::SurfaceQuery(std::vector<Vec3f> positions_cm, std::vector<SurfaceTriangle> triangles)
    : positions_(std::move(positions_cm)), triangles_(std::move(triangles)) {
  positions_.emplace_back();  // Embree reads 16 bytes at the last
  for (const SurfaceTriangle& triangle : triangles_)
    corners_.insert(corners_.end(), triangle.corner, triangle.corner + 3);
  tree_ = surface::TriangleTree(positions_, corners_.data(), triangles_.size(), {true, false});
}

Vec3f SurfaceQuery::normal(uint32_t triangle) const {
  const uint32_t* corner = triangles_[triangle].corner;
  const Vec3f a = positions_[corner[0]];
  return normalised(cross(positions_[corner[1]] - a, positions_[corner[2]] - a));
}

Vec3f SurfaceQuery::at(const SurfaceHit& hit) const {
  const uint32_t* corner = triangles_[hit.triangle].corner;
  return (1 - hit.u - hit.v) * positions_[corner[0]] + hit.u * positions_[corner[1]] +
         hit.v * positions_[corner[2]];
}

SurfaceHit SurfaceQuery::first_hit(Vec3f origin, Vec3f direction, float reach_cm) const {
  SurfaceHit found;
  if (triangles_.empty()) return found;
  RTCRayHit ray{};
  ray.ray = {origin.x,    origin.y, origin.z, 0,           direction.x, direction.y,
             direction.z, 0,        reach_cm, 0xffffffffu, 0,           0};
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  surface::intersect_one(tree_.scene(), ray);
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return found;
  return {true, ray.hit.primID, ray.hit.u, ray.hit.v, ray.ray.tfar, normal(ray.hit.primID)};
}

bool SurfaceQuery::is_blocked(Vec3f origin, Vec3f direction, float reach_cm) const {
  if (triangles_.empty()) return false;
  RTCRay ray{origin.x,    origin.y, origin.z, 0,           direction.x, direction.y,
             direction.z, 0,        reach_cm, 0xffffffffu, 0,           0};
  surface::occluded_one(tree_.scene(), ray);
  return ray.tfar < 0;
}

void nearest_in_triangle(Vec3f p, Vec3f a, Vec3f b, Vec3f c, float& v, float& w) {
  const Vec3f ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const float d1 = dot(ab, ap), d2 = dot(ac, ap), d3 = dot(ab, bp), d4 = dot(ac, bp), d5 = dot(ab, cp),
              d6 = dot(ac, cp);
  v = w = 0;
  if (d1 <= 0 && d2 <= 0) return;
  if (d3 >= 0 && d4 <= d3) return void(v = 1);
  if (d6 >= 0 && d5 <= d6) return void(w = 1);
  const float vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return void(v = d1 / (d1 - d3));
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return void(w = d2 / (d2 - d6));
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    v = 1 - w;
    return;
  }
  const float sum = va + vb + vc;
  if (!(std::fabs(sum) > 0)) return;
  v = vb / sum, w = vc / sum;
}

namespace {

struct NearestSearch {
  const std::vector<Vec3f>* positions;
  const std::vector<SurfaceTriangle>* triangles;
  const std::function<bool(uint32_t)>* counts;
  Vec3f point;
  SurfaceHit found;
};

bool visit(RTCPointQueryFunctionArguments* arguments) {
  NearestSearch& search = *static_cast<NearestSearch*>(arguments->userPtr);
  const uint32_t triangle = arguments->primID;
  if (*search.counts && !(*search.counts)(triangle)) return false;
  const uint32_t* corner = (*search.triangles)[triangle].corner;
  const Vec3f a = (*search.positions)[corner[0]], b = (*search.positions)[corner[1]],
              c = (*search.positions)[corner[2]];
  float v, w;
  nearest_in_triangle(search.point, a, b, c, v, w);
  const float distance = length(search.point - ((1 - v - w) * a + v * b + w * c));
  // Of equals the lowest number counts, whatever the order of the visits.
  if (distance > arguments->query->radius) return false;
  if (search.found.found && distance == search.found.distance_cm && triangle > search.found.triangle)
    return false;
  search.found = {true, triangle, v, w, distance, {}};
  arguments->query->radius = distance;
  return true;
}

}  // namespace

SurfaceHit SurfaceQuery::nearest(Vec3f point, float reach_cm,
                                 const std::function<bool(uint32_t)>& counts) const {
  if (triangles_.empty()) return {};
  NearestSearch search{&positions_, &triangles_, &counts, point, {}};
  RTCPointQuery query{point.x, point.y, point.z, 0, reach_cm};
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(tree_.scene(), &query, &context, visit, &search);
  if (search.found.found) search.found.normal = normal(search.found.triangle);
  return search.found;
}

}  // namespace ohb::people
