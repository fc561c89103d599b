#include "dataset/model/gltf_nodes.h"

#include <algorithm>
#include <cmath>

namespace ohb {
namespace {

using nlohmann::json;

Affine local_transform(const json& node) {
  Affine a;
  if (node.contains("matrix")) {
    const auto m = numbers_or<16>(node, "matrix", {});
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 4; ++j) a(i, j) = m[static_cast<size_t>(j * 4 + i)];
    return a;
  }
  const auto t = numbers_or<3>(node, "translation", {0, 0, 0});
  const auto q = numbers_or<4>(node, "rotation", {0, 0, 0, 1});
  const auto s = numbers_or<3>(node, "scale", {1, 1, 1});
  const double x = q[0], y = q[1], z = q[2], w = q[3];
  const double r[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
                          {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
                          {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) a(i, j) = r[i][j] * s[static_cast<size_t>(j)];
    a(i, 3) = t[static_cast<size_t>(i)];
  }
  return a;
}

bool is_finite(const Affine& a) {
  return std::all_of(a.m.begin(), a.m.end(), [](double x) { return std::isfinite(x); });
}

std::vector<size_t> children_of(const json& node) {
  return node.value("children", std::vector<size_t>());
}

}  // namespace

GltfNodes::GltfNodes(const GltfFile& gltf) : gltf_(gltf) {
  place_all();
  walk_scene();
}

void GltfNodes::refuse_loop(size_t node) const {
  gltf_.fail(gltf_place("nodes", node), "has two parents or is its own ancestor", "export the scene again");
}

/// From the roots down, without recursion; nodes of a loop stay unplaced.
void GltfNodes::place_all() {
  const size_t count = gltf_.count("nodes");
  world_.resize(count);
  is_placed_.assign(count, false);
  std::vector<bool> has_parent(count, false);
  for (size_t i = 0; i < count; ++i)
    for (size_t child : children_of(gltf_.item("nodes", i))) {
      gltf_.item("nodes", child);  // is there
      if (has_parent[child]) refuse_loop(child);
      has_parent[child] = true;
    }
  std::vector<size_t> open;
  const auto place = [&](size_t node, const Affine& parent) {
    world_[node] = parent * local_transform(gltf_.item("nodes", node));
    if (!is_finite(world_[node]))
      gltf_.fail(gltf_place("nodes", node), "has a transform that is not finite", "correct it");
    is_placed_[node] = true;
    open.push_back(node);
  };
  for (size_t i = 0; i < count; ++i)
    if (!has_parent[i]) place(i, Affine());
  while (!open.empty()) {
    const size_t node = open.back();
    open.pop_back();
    for (size_t child : children_of(gltf_.item("nodes", node))) place(child, world_[node]);
  }
  if (gltf_.count("scenes") > 0) return;
  for (size_t i = 0; i < count; ++i)
    if (!is_placed_[i]) refuse_loop(i);
}

void GltfNodes::walk_scene() {
  std::vector<size_t> stack;
  if (gltf_.count("scenes") > 0) {
    stack = gltf_.item("scenes", index_or(gltf_.root(), "scene", 0)).value("nodes", std::vector<size_t>());
  } else {
    std::vector<bool> is_child(world_.size(), false);
    for (size_t i = 0; i < world_.size(); ++i)
      for (size_t child : children_of(gltf_.item("nodes", i))) is_child[child] = true;
    for (size_t i = 0; i < world_.size(); ++i)
      if (!is_child[i]) stack.push_back(i);
  }
  std::reverse(stack.begin(), stack.end());
  std::vector<bool> seen(world_.size(), false);
  while (!stack.empty()) {
    const size_t node = stack.back();
    stack.pop_back();
    const std::vector<size_t> children = children_of(gltf_.item("nodes", node));
    if (seen[node] || !is_placed_[node]) refuse_loop(node);
    seen[node] = true;
    in_scene_.push_back(node);
    stack.insert(stack.end(), children.rbegin(), children.rend());
  }
}

std::vector<Affine> GltfNodes::joint_matrices(size_t skin) const {
  const json& object = gltf_.item("skins", skin);
  const std::string place = gltf_place("skins", skin);
  const auto joints = object.at("joints").get<std::vector<size_t>>();
  std::vector<float> inverse_bind;
  const size_t accessor = index_or(object, "inverseBindMatrices");
  if (accessor != kMissing) {
    inverse_bind = gltf_.floats(accessor, 16);
    if (inverse_bind.size() < 16 * joints.size())
      gltf_.fail(place,
                 "has " + std::to_string(inverse_bind.size() / 16) + " inverse bind matrices for " +
                     std::to_string(joints.size()) + " joints",
                 kGltfExportAgain);
  }
  std::vector<Affine> matrices;
  for (size_t k = 0; k < joints.size(); ++k) {
    gltf_.item("nodes", joints[k]);  // is there
    if (!is_placed_[joints[k]]) refuse_loop(joints[k]);
    Affine inverse;
    if (!inverse_bind.empty())
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 4; ++j) inverse(i, j) = inverse_bind[16 * k + static_cast<size_t>(4 * j + i)];
    matrices.push_back(world_[joints[k]] * inverse);
    if (!is_finite(matrices.back()))
      gltf_.fail(place, "has an inverse bind matrix that is not finite", "export it again without the rig");
  }
  return matrices;
}

}  // namespace ohb
