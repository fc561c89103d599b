// glTF 2.0 (.glb, .gltf): triangles of the default scene, node transforms applied, rigs in the pose of the
// file's nodes, morph targets at their default weights. Our UVs have v up, glTF's have v down. The unit is
// the metre.
#include <algorithm>
#include <array>
#include <cmath>

#include "dataset/model/error.h"
#include "dataset/model/gltf_materials.h"
#include "dataset/model/gltf_primitive.h"
#include "dataset/model/scan_readers.h"

namespace ohb {
namespace {

using nlohmann::json;

class GltfReader {
 public:
  explicit GltfReader(const std::filesystem::path& file)
      : gltf_(file), nodes_(gltf_), files_(scan_), materials_(gltf_, files_) {
    scan_.file = file;
    scan_.stated_unit_cm = 100;
  }

  Scan read() {
    for (size_t i = 0; i < gltf_.count("materials"); ++i) read_material(i);
    for (const size_t node : nodes_.in_scene())
      if (gltf_.item("nodes", node).contains("mesh")) read_mesh(gltf_.item("nodes", node), node);
    close_faces(scan_);
    if (!scan_.corner_colours.empty()) scan_.corner_colours.resize(scan_.corners.size());
    store_and_weld();
    if (scan_.materials.empty()) scan_.materials.emplace_back().name = "default";
    if (scan_.groups.empty()) scan_.groups.push_back("default");
    add_notes();
    return std::move(scan_);
  }

 private:
  /// One object's part of all positions and corners.
  struct Part {
    size_t first_position, first_corner;
  };

  void read_material(size_t index) {
    scan_.materials.push_back(materials_.read(index));
    uv_sets_.push_back(materials_.uv_set());
    ignores_alpha_.push_back(materials_.ignores_alpha());
  }

  void read_mesh(const json& node, size_t node_index) {
    const size_t mesh_index = index_or(node, "mesh");
    const json& mesh = gltf_.item("meshes", mesh_index);
    GltfPlacement placement;
    placement.world = nodes_.world(node_index);
    if (node.contains("skin")) {
      placement.joints = nodes_.joint_matrices(index_or(node, "skin"));
      is_rigged_ = true;
    }
    for (const json* of : {&node, &mesh})
      if (of->contains("weights") && placement.weights.empty())
        placement.weights = of->at("weights").get<std::vector<double>>();
    has_copies_ = has_copies_ ||
                  (node.contains("extensions") && node.at("extensions").contains("EXT_mesh_gpu_instancing"));
    const std::string name = node.value("name", mesh.value("name", "node" + std::to_string(node_index)));
    const size_t group = group_of(name);
    parts_.push_back({positions_.size(), scan_.corners.size()});
    const json& primitives = mesh.at("primitives");
    for (size_t p = 0; p < primitives.size(); ++p)
      read_primitive(primitives.at(p), gltf_place("meshes", mesh_index) + "." + gltf_place("primitives", p),
                     placement, group);
  }

  size_t group_of(const std::string& name) {
    const auto [found, is_new] = groups_.emplace(name, scan_.groups.size());
    if (is_new) scan_.groups.push_back(name);
    if (scan_.groups.size() > kMaxScanNames) gltf_.fail("nodes", "has too many objects", "join some of them");
    return found->second;
  }

  void read_primitive(const json& from, const std::string& place, const GltfPlacement& placement,
                      size_t group) {
    const size_t mode = index_or(from, "mode", 4);
    if (mode < 4) return;  // points and lines
    if (mode > 6) gltf_.fail(place, "has the unknown mode " + std::to_string(mode), "export triangles");
    const GltfPrimitive primitive(gltf_, from, place);
    if (primitive.has("NORMAL")) scan_.has_file_normals = true;
    if (from.contains("targets")) {
      most_targets_ = std::max(most_targets_, from.at("targets").size());
      for (double weight : placement.weights) is_morphed_ = is_morphed_ || weight != 0;
    }
    const size_t material = material_of(from, place);
    bool mirrors = false;
    const auto base = static_cast<uint32_t>(positions_.size());
    const std::vector<Vec3d> points = primitive.positions(placement, mirrors);
    check_room(positions_.size() + points.size(), place);
    positions_.insert(positions_.end(), points.begin(), points.end());
    const uint32_t uv_base = add_uvs(primitive.uvs(uv_sets_.at(material), points.size()), place);
    const size_t first_corner = scan_.corners.size();
    const std::vector<uint32_t> order = primitive.order(points.size());
    check_room(scan_.corners.size() + 3 * order.size(), place);
    for (const std::array<size_t, 3>& at : triangles_of(order.size(), mode, mirrors, place)) {
      begin_face(scan_, material, group);
      for (size_t i : at)
        scan_.corners.push_back(
            {base + order[i], uv_base == Corner::kNoUv ? Corner::kNoUv : uv_base + order[i]});
    }
    add_colours(primitive.colours(points.size()), material, base, first_corner);
  }

  size_t material_of(const json& primitive, const std::string& place) {
    const size_t material = index_or(primitive, "material");
    if (material != kMissing) {
      if (material >= gltf_.count("materials"))
        gltf_.fail(place, "names no material of the file", "export it again");
      return material;
    }
    if (default_material_ == kMissing) {
      default_material_ = scan_.materials.size();
      scan_.materials.emplace_back().name = "default";
      uv_sets_.push_back(0);
      ignores_alpha_.push_back(true);
    }
    return default_material_;
  }

  /// Index of the first added UV; kNoUv if there are none.
  uint32_t add_uvs(const std::vector<float>& values, const std::string& place) {
    if (values.empty()) return Corner::kNoUv;
    const auto base = static_cast<uint32_t>(scan_.uvs.size());
    check_room(scan_.uvs.size() + values.size() / 2, place);
    for (size_t i = 0; i + 1 < values.size(); i += 2) scan_.uvs.push_back({values[i], 1.0f - values[i + 1]});
    return base;
  }

  /// Which of `count` indices make each triangle of a list (mode 4), strip (5) or fan (6).
  std::vector<std::array<size_t, 3>> triangles_of(size_t count, size_t mode, bool mirrored,
                                                  const std::string& place) const {
    if (mode == 4 && count % 3 != 0)
      gltf_.fail(place, "has " + std::to_string(count) + " indices, which is no multiple of 3",
                 "export the scan again");
    std::vector<std::array<size_t, 3>> triangles;
    if (count < 3) return triangles;
    triangles.resize(mode == 4 ? count / 3 : count - 2);
    for (size_t t = 0; t < triangles.size(); ++t) {
      std::array<size_t, 3>& at = triangles[t] = {t, t + 1, t + 2};
      if (mode == 4) at = {3 * t, 3 * t + 1, 3 * t + 2};
      if (mode == 6) at[0] = 0;
      if ((mode == 5 && t % 2 == 1) != mirrored) std::swap(at[1], at[2]);
    }
    return triangles;
  }

  /// Gives the corners from first_corner on their colours; their positions are still vertices of the
  /// primitive.
  void add_colours(const std::vector<VertexColour>& colours, size_t material, uint32_t base,
                   size_t first_corner) {
    if (colours.empty()) return;
    scan_.corner_colours.resize(first_corner);
    for (size_t c = first_corner; c < scan_.corners.size(); ++c) {
      scan_.corner_colours.push_back(colours[scan_.corners[c].position - base]);
      if (ignores_alpha_.at(material)) scan_.corner_colours.back().alpha = 1;
    }
  }

  /// Positions in single precision, welded within each object.
  void store_and_weld() {
    store_positions(scan_, positions_);
    std::vector<Vec3f> positions;
    std::vector<Corner> corners;
    positions.swap(scan_.positions);
    corners.swap(scan_.corners);
    parts_.push_back({positions.size(), corners.size()});
    for (size_t i = 0; i + 1 < parts_.size(); ++i) {
      const Part from = parts_[i], end = parts_[i + 1];
      const size_t first = scan_.positions.size();
      scan_.positions.insert(scan_.positions.end(),
                             positions.begin() + static_cast<ptrdiff_t>(from.first_position),
                             positions.begin() + static_cast<ptrdiff_t>(end.first_position));
      for (size_t c = from.first_corner; c < end.first_corner; ++c)
        scan_.corners.push_back(
            {static_cast<uint32_t>(corners[c].position - from.first_position + first), corners[c].uv});
      weld_positions(scan_, first, from.first_corner);
    }
  }

  void add_notes() {
    for (const std::string& note : materials_.notes()) scan_.notes.push_back(note);
    if (is_rigged_) scan_.notes.push_back("the mesh is rigged: it takes the pose of the file's nodes");
    if (most_targets_ > 0)
      scan_.notes.push_back(is_morphed_ ? "morph targets are applied at their default weights"
                                        : "morph targets are at rest: their default weights are 0");
    if (gltf_.count("animations") > 0) scan_.notes.push_back("animations are not used");
    if (has_copies_) scan_.notes.push_back("copies by EXT_mesh_gpu_instancing are left out");
    if (!scan_.corner_colours.empty())
      scan_.notes.push_back("colours at the vertices multiply the materials' colours");
  }

  void check_room(size_t count, const std::string& place) const {
    if (count > kMaxScanElements)
      gltf_.fail(place, "brings the scan to " + std::to_string(count) + " elements",
                 "a scan may have " + std::to_string(kMaxScanElements));
  }

  GltfFile gltf_;
  GltfNodes nodes_;
  Scan scan_;
  ScanFiles files_;
  GltfMaterials materials_;
  std::vector<Vec3d> positions_;
  std::vector<Part> parts_;
  std::map<std::string, size_t> groups_;
  std::vector<size_t> uv_sets_;      // of each material
  std::vector<bool> ignores_alpha_;  // of each material
  size_t default_material_ = kMissing, most_targets_ = 0;
  bool is_rigged_ = false, is_morphed_ = false, has_copies_ = false;
};

}  // namespace

Scan read_gltf(const std::filesystem::path& file) {
  try {
    return GltfReader(file).read();
  } catch (const json::exception& error) {
    // A member of a type that glTF does not allow there: "[json.exception...] type must be array, but is
    // null".
    const std::string text = error.what();
    throw InputError(file.string(), "JSON",
                     text.substr(text.find(']') == std::string::npos ? 0 : text.find(']') + 2),
                     "export the scan again");
  }
}

}  // namespace ohb
