// The nodes of a glTF scene: where they lie, and the matrices of skins.
#pragma once

#include <vector>

#include "dataset/model/affine.h"
#include "dataset/model/gltf_file.h"

namespace ohb {

class GltfNodes {
 public:
  /// All throw InputError naming the node: two parents, its own ancestor, a transform that is none.
  explicit GltfNodes(const GltfFile& gltf);

  /// Nodes of the default scene (of the whole file without one), parents first, children in their order.
  const std::vector<size_t>& in_scene() const { return in_scene_; }
  /// Into the scene's frame.
  const Affine& world(size_t node) const { return world_[node]; }
  /// What each joint of the skin does to a vertex of a mesh: the joint's place by the nodes' own transforms,
  /// after the inverse bind matrix. A skinned mesh ignores its own node's transform.
  std::vector<Affine> joint_matrices(size_t skin) const;

 private:
  void place_all();
  void walk_scene();
  [[noreturn]] void refuse_loop(size_t node) const;

  const GltfFile& gltf_;
  std::vector<Affine> world_;
  std::vector<bool> is_placed_;
  std::vector<size_t> in_scene_;
};

/// Numbers of a JSON array; `missing` if the key is not there.
template <size_t N>
std::array<double, N> numbers_or(const nlohmann::json& object, const char* key,
                                 std::array<double, N> missing) {
  const auto found = object.find(key);
  return found == object.end() ? missing : found->get<std::array<double, N>>();
}

}  // namespace ohb
