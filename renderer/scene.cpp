#include "renderer/scene.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "dataset/model/tangent_frame.h"

namespace ohb::renderer {
namespace {

// Hit points are computed from the corners; their error is a few units in the last place of the largest
// coordinate. 32 of them clear it with a wide margin and are 5 micrometres on a human.
constexpr float kOffsetUlps = 32;

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
  set_triangles(model, order);

  opaque_tree_ = surface::TriangleTree(positions, indices.data(), opaque_count);
  cutout_tree_ = surface::TriangleTree(positions, indices.data() + 3 * size_t{opaque_count},
                                       order.size() - opaque_count, {false, true});
  opaque = opaque_tree_.scene();
  cutout = cutout_tree_.scene();
}

void Scene::set_triangles(const Model& model, const std::vector<uint32_t>& order) {
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
}

std::shared_ptr<const Scene> build_scene(const Model& model) {
  return std::make_shared<const Scene>(model);
}

}  // namespace ohb::renderer
