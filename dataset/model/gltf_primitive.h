// One primitive of a glTF mesh: its attributes, wherever they are stored, and its points placed in the scene.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dataset/model/gltf_draco.h"
#include "dataset/model/gltf_nodes.h"
#include "dataset/model/scan.h"

namespace ohb {

/// How a mesh's points get into the scene: by its node, or by the joints of its skin.
struct GltfPlacement {
  Affine world;
  std::vector<Affine> joints;   // empty: no skin
  std::vector<double> weights;  // of morph targets
};

/// All functions throw InputError naming the primitive.
class GltfPrimitive {
 public:
  /// Decodes KHR_draco_mesh_compression. `json` and `gltf` must outlive this.
  GltfPrimitive(const GltfFile& gltf, const nlohmann::json& json, std::string place);

  const std::string& place() const { return place_; }
  bool has(const std::string& attribute) const { return attributes_.contains(attribute); }
  /// Vertices in the scene's frame: default morph weights, then the skin or the node's transform. `mirrors`
  /// tells whether that turns the surface inside out.
  std::vector<Vec3d> positions(const GltfPlacement& placement, bool& mirrors) const;
  /// Two numbers a vertex, v down. `vertex_count` of them.
  std::vector<float> uvs(size_t set, size_t vertex_count) const;
  /// COLOR_0, values below 0 as 0; empty without.
  std::vector<VertexColour> colours(size_t vertex_count) const;
  /// Vertices in the order of the faces' corners, each below vertex_count.
  std::vector<uint32_t> order(size_t vertex_count) const;

 private:
  std::vector<float> floats(const std::string& attribute, size_t components) const;
  void add_morph_targets(const std::vector<double>& weights, std::vector<Vec3d>& points) const;
  void apply_skin(const std::vector<Affine>& joints, std::vector<Vec3d>& points, bool& mirrors) const;
  void check_count(const char* what, size_t found, size_t vertex_count) const;
  [[noreturn]] void fail(const std::string& cause, const std::string& mend = kGltfExportAgain) const;

  const GltfFile& gltf_;
  const nlohmann::json& json_;
  const nlohmann::json& attributes_;
  std::string place_;
  std::optional<DracoMesh> draco_;
  nlohmann::json draco_ids_;  // of its attributes
};

}  // namespace ohb
