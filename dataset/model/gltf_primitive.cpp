#include "dataset/model/gltf_primitive.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "dataset/model/scan_readers.h"

namespace ohb {
namespace {

using nlohmann::json;

constexpr const char* kDraco = "KHR_draco_mesh_compression";
constexpr size_t kMostInfluenceSets = 8;

bool is_finite(const Vec3d& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

}  // namespace

GltfPrimitive::GltfPrimitive(const GltfFile& gltf, const json& json, std::string place)
    : gltf_(gltf), json_(json), attributes_(json.at("attributes")), place_(std::move(place)) {
  const auto extensions = json.find("extensions");
  if (extensions == json.end() || !extensions->contains(kDraco)) return;
  const auto& compression = extensions->at(kDraco);
  try {
    draco_.emplace(gltf_.buffer_view(index_or(compression, "bufferView")));
  } catch (const std::runtime_error& error) {
    fail(std::string("has ") + kDraco + " data that cannot be decoded (" + error.what() + ")",
         "export it again, without compression");
  }
  draco_ids_ = compression.at("attributes");
}

void GltfPrimitive::fail(const std::string& cause, const std::string& mend) const {
  gltf_.fail(place_, cause, mend);
}

void GltfPrimitive::check_count(const char* what, size_t found, size_t vertex_count) const {
  if (found != vertex_count)
    fail("has " + std::to_string(found) + " " + what + " for " + std::to_string(vertex_count) + " vertices");
}

std::vector<float> GltfPrimitive::floats(const std::string& attribute, size_t components) const {
  if (!draco_ || !draco_ids_.contains(attribute))
    return gltf_.floats(index_or(attributes_, attribute.c_str()), components);
  try {
    return draco_->floats(index_or(draco_ids_, attribute.c_str()), components);
  } catch (const std::runtime_error& error) {
    fail(std::string(kDraco) + ": " + attribute + " " + error.what(), "export it again, without compression");
  }
}

std::vector<Vec3d> GltfPrimitive::positions(const GltfPlacement& placement, bool& mirrors) const {
  if (!has("POSITION")) fail("has no POSITION");
  const std::vector<float> values = floats("POSITION", 3);
  std::vector<Vec3d> points;
  points.reserve(values.size() / 3);
  for (size_t i = 0; i + 2 < values.size(); i += 3)
    points.push_back({values[i], values[i + 1], values[i + 2]});
  add_morph_targets(placement.weights, points);
  if (!placement.joints.empty() && has("JOINTS_0") && has("WEIGHTS_0")) {
    apply_skin(placement.joints, points, mirrors);
  } else {
    for (Vec3d& p : points) p = transformed(placement.world, p);
    mirrors = determinant(placement.world) < 0;
  }
  for (size_t i = 0; i < points.size(); ++i)
    if (!is_finite(points[i]))
      fail(numbered("vertex", i) + " is not finite", "remove the vertex and its faces");
  return points;
}

void GltfPrimitive::add_morph_targets(const std::vector<double>& weights, std::vector<Vec3d>& points) const {
  if (!json_.contains("targets")) return;
  const json& targets = json_.at("targets");
  for (size_t t = 0; t < std::min(targets.size(), weights.size()); ++t) {
    const size_t accessor = index_or(targets.at(t), "POSITION");
    if (weights[t] == 0 || accessor == kMissing) continue;
    const std::vector<float> moves = gltf_.floats(accessor, 3);
    check_count("moves of a morph target", moves.size() / 3, points.size());
    for (size_t i = 0; i < points.size(); ++i) {
      points[i].x += weights[t] * moves[3 * i];
      points[i].y += weights[t] * moves[3 * i + 1];
      points[i].z += weights[t] * moves[3 * i + 2];
    }
  }
}

/// Linear blend skinning, weights brought to the sum 1; vertices without weights stay where they are.
void GltfPrimitive::apply_skin(const std::vector<Affine>& joints, std::vector<Vec3d>& points,
                               bool& mirrors) const {
  std::vector<Vec3d> moved(points.size());
  std::vector<double> sums(points.size(), 0);
  double turned = 0, kept = 0;
  for (size_t set = 0; set < kMostInfluenceSets; ++set) {
    const std::string joint_name = "JOINTS_" + std::to_string(set),
                      weight_name = "WEIGHTS_" + std::to_string(set);
    if (!has(joint_name) || !has(weight_name)) break;
    const std::vector<float> indices = floats(joint_name, 4), weights = floats(weight_name, 4);
    check_count("joints", indices.size() / 4, points.size());
    check_count("weights", weights.size() / 4, points.size());
    for (size_t i = 0; i < indices.size(); ++i) {
      const double weight = weights[i];
      if (weight == 0) continue;
      if (!(weight > 0 && weight < 1e6)) fail(numbered("vertex", i / 4) + " has a weight that is none");
      const auto joint = static_cast<size_t>(std::max(indices[i], 0.0f));
      if (joint >= joints.size())
        fail(numbered("vertex", i / 4) + " uses joint " + std::to_string(joint) + " of " +
             std::to_string(joints.size()));
      const Vec3d p = transformed(joints[joint], points[i / 4]);
      Vec3d& to = moved[i / 4];
      to = {to.x + weight * p.x, to.y + weight * p.y, to.z + weight * p.z};
      sums[i / 4] += weight;
      (determinant(joints[joint]) < 0 ? turned : kept) += weight;
    }
  }
  for (size_t i = 0; i < points.size(); ++i)
    if (sums[i] > 0) points[i] = {moved[i].x / sums[i], moved[i].y / sums[i], moved[i].z / sums[i]};
  mirrors = turned > kept;
}

std::vector<float> GltfPrimitive::uvs(size_t set, size_t vertex_count) const {
  const std::string name = "TEXCOORD_" + std::to_string(set);
  if (!has(name)) return {};
  std::vector<float> values = floats(name, 2);
  check_count("UVs", values.size() / 2, vertex_count);
  for (size_t i = 0; i < values.size(); ++i)
    if (!std::isfinite(values[i])) fail(numbered("UV", i / 2) + " is not finite", "unwrap its faces again");
  return values;
}

std::vector<VertexColour> GltfPrimitive::colours(size_t vertex_count) const {
  if (!has("COLOR_0")) return {};
  size_t channels = 0;
  if (draco_ && draco_ids_.contains("COLOR_0"))
    channels = draco_->components(index_or(draco_ids_, "COLOR_0"));
  else
    channels = gltf_.components(index_or(attributes_, "COLOR_0"));
  if (channels != 3 && channels != 4) fail("has colours of " + std::to_string(channels) + " channels");
  const std::vector<float> values = floats("COLOR_0", channels);
  check_count("colours", values.size() / channels, vertex_count);
  std::vector<VertexColour> colours(vertex_count);
  for (size_t i = 0; i < vertex_count; ++i) {
    const float* const from = &values[channels * i];
    for (size_t c = 0; c < channels; ++c)
      if (!std::isfinite(from[c])) fail(numbered("colour", i) + " is not finite", "remove the colours");
    colours[i].rgb = {std::max(from[0], 0.0f), std::max(from[1], 0.0f), std::max(from[2], 0.0f)};
    if (channels == 4) colours[i].alpha = std::clamp(from[3], 0.0f, 1.0f);
  }
  return colours;
}

std::vector<uint32_t> GltfPrimitive::order(size_t vertex_count) const {
  std::vector<uint32_t> order;
  if (draco_) {
    order = draco_->indices();
  } else if (json_.contains("indices")) {
    order = gltf_.indices(index_or(json_, "indices"));
  } else {
    order.resize(vertex_count);
    for (size_t i = 0; i < vertex_count; ++i) order[i] = static_cast<uint32_t>(i);
  }
  for (size_t i = 0; i < order.size(); ++i)
    if (order[i] >= vertex_count)
      fail("index " + std::to_string(i) + " is " + std::to_string(order[i]) + " but it has " +
           std::to_string(vertex_count) + " vertices");
  return order;
}

}  // namespace ohb
