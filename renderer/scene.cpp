#include "renderer/scene.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <stdexcept>

#include "dataset/model/tangent_frame.h"

namespace ohb::renderer {
namespace {

// Hit points are computed from the corners; their error is a few units in the last place of the largest
// coordinate. 32 of them clear it with a wide margin and are 5 micrometres on a human.
constexpr float kOffsetUlps = 32;

void throw_embree_error(void*, RTCError code, const char* message) {
  throw std::runtime_error("Embree error " + std::to_string(code) + ": " + message);
}

RTCScene build_bvh(RTCDevice device, const Scene& scene, uint32_t first, uint32_t count, bool is_cut) {
  if (count == 0) return nullptr;
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, scene.positions.data(),
                             0, sizeof(Vec3f), scene.positions.size() - 1);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, scene.indices.data(),
                             size_t{first} * 3 * sizeof(uint32_t), 3 * sizeof(uint32_t), count);
  rtcCommitGeometry(geometry);
  RTCScene bvh = rtcNewScene(device);
  // Splitting triangles (HIGH) takes three times as long to build, and people's even meshes are no faster by
  // it.
  rtcSetSceneBuildQuality(bvh, RTC_BUILD_QUALITY_MEDIUM);
  if (is_cut) surface::allow_filters(bvh, geometry);
  rtcAttachGeometry(bvh, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(bvh);
  return bvh;
}

TriangleAttributes attributes_of(const ModelTriangle& triangle, const Model& model,
                                 const std::vector<Vec3f>& normals) {
  TriangleAttributes a;
  for (int c = 0; c < 3; ++c) {
    a.normal[c] = normals[triangle.position[c]];
    a.uv[c] = model.uvs[triangle.uv[c]];
  }
  a.set = triangle.set;
  a.material_class = triangle.material_class;
  a.has_normal_map = !model.sets[triangle.set].normal.values.empty();
  return a;
}

}  // namespace

Scene::Scene(const Model& model) : positions(model.positions_cm), bounds(bounds_of(model.positions_cm)) {
  float largest = 0;
  for (const Vec3f& p : positions)
    largest = std::max({largest, std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)});
  self_hit_offset_cm = kOffsetUlps * (std::nextafter(largest, INFINITY) - largest);
  positions.push_back({});

  sets.reserve(model.sets.size());
  for (const TextureSet& set : model.sets) sets.emplace_back(set);
  std::vector<uint32_t> order(model.triangles.size());
  for (uint32_t t = 0; t < order.size(); ++t) order[t] = t;
  const auto first_cutout = std::stable_partition(
      order.begin(), order.end(), [&](uint32_t t) { return !sets[model.triangles[t].set].has_alpha(); });
  opaque_count = static_cast<uint32_t>(first_cutout - order.begin());

  const std::vector<Vec3f> normals = model.normals.empty() ? smooth_normals(model) : model.normals;
  if (normals.size() != model.positions_cm.size())
    throw std::logic_error("build_scene: " + std::to_string(normals.size()) + " normals of " +
                           std::to_string(model.positions_cm.size()) + " positions");
  const bool any_normal_map =
      std::any_of(sets.begin(), sets.end(), [](const Texels& texels) { return texels.has_normals(); });
  std::vector<CornerTangent> corner_tangents;
  if (any_normal_map) corner_tangents = mikktspace_tangents(model, normals);
  indices.reserve(3 * order.size());
  attributes.reserve(order.size());
  tangents.reserve(any_normal_map ? order.size() : 0);
  for (const uint32_t t : order) {
    const ModelTriangle& triangle = model.triangles[t];
    indices.insert(indices.end(), triangle.position, triangle.position + 3);
    attributes.push_back(attributes_of(triangle, model, normals));
    if (!any_normal_map) continue;
    const CornerTangent* corner = &corner_tangents[3 * size_t{t}];
    tangents.push_back({{corner[0].tangent, corner[1].tangent, corner[2].tangent},
                        {corner[0].sign, corner[1].sign, corner[2].sign}});
  }

  device_ = rtcNewDevice(nullptr);
  if (!device_) throw std::bad_alloc();  // the only thing that it can lack here
  rtcSetDeviceErrorFunction(device_, throw_embree_error, nullptr);
  opaque = build_bvh(device_, *this, 0, opaque_count, false);
  cutout = build_bvh(device_, *this, opaque_count, static_cast<uint32_t>(order.size()) - opaque_count, true);
}

Scene::~Scene() {
  if (opaque) rtcReleaseScene(opaque);
  if (cutout) rtcReleaseScene(cutout);
  rtcReleaseDevice(device_);
}

std::shared_ptr<const Scene> build_scene(const Model& model) {
  return std::make_shared<const Scene>(model);
}

}  // namespace ohb::renderer
