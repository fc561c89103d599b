#include "bake/ambient_light.h"

#include <tbb/parallel_for.h>

#include <cmath>
#include <limits>

#include "dataset/model/sampling.h"
#include "dataset/surface/triangle_tree.h"

namespace ohb::bake {
namespace {

constexpr float kStartShare = 1e-4f;  // of the mesh's diagonal: how far above the surface rays start

/// The triangles that stand in the way.
struct Occluders {
  std::vector<Vec3f> positions;  // one more than there are: Embree reads 16 bytes at the last
  std::vector<uint32_t> indices, triangle_of;
  surface::TriangleTree tree;

  Occluders(const Model& mesh, const std::vector<uint8_t>& occludes) : positions(mesh.positions_cm) {
    positions.emplace_back();
    for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      if (!occludes[t]) continue;
      indices.insert(indices.end(), mesh.triangles[t].position, mesh.triangles[t].position + 3);
      triangle_of.push_back(t);
    }
    tree = surface::TriangleTree(positions, indices.data(), triangle_of.size(), {true, false});
  }
};

float fraction(double x) {
  return static_cast<float>(x - std::floor(x));
}

/// What every point asks alike.
struct AmbientQuery {
  const Occluders& occluders;
  const Model& mesh;
  const std::vector<Vec3f>& glow;  // one a point
  float start_cm;
  int rays;
};

Vec3f irradiance_at(const AmbientQuery& query, uint32_t p, Vec3f normal) {
  const auto& [occluders, mesh, glow, start_cm, rays] = query;
  const float turn_x = fraction(p * 0.7548776662466927), turn_y = fraction(p * 0.5698402909980532);
  const Frame frame(normal);
  Vec3f sum{0, 0, 0};
  const Vec3f origin = mesh.positions_cm[p] + start_cm * normal;
  for (int i = 0; i < rays; ++i) {
    const float u = fraction((i + 0.5) / rays + turn_x);
    // Van der Corput's sequence in base 2 beside the regular one: Hammersley's points, turned.
    const float v = static_cast<float>(reverse_bits(static_cast<uint32_t>(i)) >> 8) * 0x1p-24f;
    const Vec3f d = frame.to_world(sample_cosine_hemisphere(u, fraction(v + turn_y)));
    RTCRayHit r{};
    r.ray.org_x = origin.x, r.ray.org_y = origin.y, r.ray.org_z = origin.z;
    r.ray.dir_x = d.x, r.ray.dir_y = d.y, r.ray.dir_z = d.z;
    r.ray.tfar = std::numeric_limits<float>::infinity();
    r.ray.mask = 0xffffffffu;
    r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    if (occluders.tree.scene()) surface::intersect_one(occluders.tree.scene(), r);
    if (r.hit.geomID == RTC_INVALID_GEOMETRY_ID) {
      sum += Vec3f{1, 1, 1};
      continue;
    }
    const uint32_t* const hit = mesh.triangles[occluders.triangle_of[r.hit.primID]].position;
    sum += (1 - r.hit.u - r.hit.v) * glow[hit[0]] + r.hit.u * glow[hit[1]] + r.hit.v * glow[hit[2]];
  }
  return sum * (1 / static_cast<float>(rays));
}

}  // namespace

std::vector<Vec3f> ambient_irradiance(const Model& mesh, const std::vector<uint8_t>& occludes,
                                      const std::vector<Vec3f>& glow, int rays) {
  const Occluders occluders(mesh, occludes);
  const std::vector<Vec3f> normals = smooth_normals(mesh);
  const Bounds bounds = bounds_of(mesh.positions_cm);
  const float start_cm = kStartShare * length(bounds.high - bounds.low);
  const AmbientQuery query{occluders, mesh, glow, start_cm, rays};
  std::vector<Vec3f> irradiance(mesh.positions_cm.size());
  tbb::parallel_for(uint32_t{0}, static_cast<uint32_t>(irradiance.size()),
                    [&](uint32_t p) { irradiance[p] = irradiance_at(query, p, normals[p]); });
  return irradiance;
}

}  // namespace ohb::bake
