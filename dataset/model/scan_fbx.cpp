// FBX 6 and 7: meshes of the scene with their polygons in file order, shape keys and node transforms applied,
// bones at rest, the file's stated up axis turned to +Y. The unit is what the file states (UnitScaleFactor,
// cm).
#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

#include "dataset/model/affine.h"
#include "dataset/model/colour.h"
#include "dataset/model/error.h"
#include "dataset/model/fbx_materials.h"
#include "dataset/model/fbx_scene.h"
#include "dataset/model/fbx_shapes.h"
#include "dataset/model/fbx_transform.h"
#include "dataset/model/scan_readers.h"

namespace ohb {
namespace {

constexpr const char* kExportAgain = "export the scan again";

/// A layer of a mesh: values that corners, vertices or faces index.
struct Layer {
  std::vector<double> values, index;
  bool has_index = false;
  std::string mapping = "ByPolygonVertex";
  bool is_by_vertex() const { return mapping == "ByVertice" || mapping == "ByVertex"; }
  /// -1: none; -2: beyond the index.
  double at(size_t item) const {
    return !has_index ? static_cast<double>(item) : item < index.size() ? index[item] : -2;
  }
};

class FbxReader {
 public:
  explicit FbxReader(const std::filesystem::path& file)
      : scene_(file), fbx_(scene_.file()), files_(scan_), materials_(scene_, scan_, files_) {
    scan_.file = file;
  }

  Scan read() {
    read_settings();
    bool has_skin = false;
    for (const FbxNode& object : scene_.objects().children) {
      if (object.name == "Model" && !object.values.empty()) read_model(object);
      const std::string type = object.name == "Deformer" ? scene_.type_of(object) : "BlendShape";
      has_skin = has_skin || (type != "BlendShape" && type != "BlendShapeChannel");
    }
    close_faces(scan_);
    store_positions(scan_, positions_);
    if (!scan_.corner_colours.empty()) settle_vertex_colours(scan_, is_coloured_);
    if (has_skin) scan_.notes.push_back("the mesh is rigged: its pose at rest is used");
    if (scene_.is_version_6()) scan_.notes.push_back("is FBX " + std::to_string(fbx_.version()));
    if (scan_.materials.empty()) scan_.materials.emplace_back().name = "default";
    if (scan_.groups.empty()) scan_.groups.push_back("default");
    return std::move(scan_);
  }

 private:
  void read_settings() {
    const FbxNode* settings = scene_.settings();
    scan_.stated_unit_cm = 1;
    if (!settings) return;
    const FbxProperties properties(fbx_, *settings);
    const double unit = properties.number("UnitScaleFactor", 1);
    if (!(unit > 1e-6 && unit < 1e6))
      fbx_.fail("UnitScaleFactor", "is " + std::to_string(unit), kExportAgain);
    scan_.stated_unit_cm = unit;
    const int up = axis(properties, "UpAxis", 1), right = axis(properties, "CoordAxis", 0);
    if (up == right) fbx_.fail("GlobalSettings", "names one axis as up and right", kExportAgain);
    const double up_sign = properties.number("UpAxisSign", 1) < 0 ? -1 : 1;
    const double right_sign = properties.number("CoordAxisSign", 1) < 0 ? -1 : 1;
    to_y_up_ = Affine();
    to_y_up_.m.fill(0);
    to_y_up_(0, right) = right_sign;
    to_y_up_(1, up) = up_sign;
    const int third = 3 - up - right;  // cross(right, up)
    to_y_up_(2, third) = ((right + 1) % 3 == up ? 1 : -1) * up_sign * right_sign;
  }

  int axis(const FbxProperties& properties, const char* name, int missing) const {
    const double value = properties.number(name, missing);
    if (value != 0 && value != 1 && value != 2) fbx_.fail(name, "is no axis", kExportAgain);
    return static_cast<int>(value);
  }

  Affine world_of(const FbxNode& model) const {
    Affine world;
    const FbxNode* node = &model;  // by node, not by id: version 6 may give one name twice
    for (int depth = 0; node; ++depth) {
      if (depth > 1000) fbx_.fail("Connections", "make a node its own ancestor", kExportAgain);
      world = fbx_local_transform(FbxProperties(fbx_, *node)) * world;
      const FbxNode* parent = nullptr;
      for (const FbxLink& link : scene_.wholes_of(scene_.id_of(*node)))
        if (const FbxNode* found = scene_.object_of(link.other, "Model")) parent = found;
      node = parent;
    }
    return to_y_up_ * world;
  }

  /// What a mesh's faces may name.
  struct Slots {
    std::vector<const FbxNode*> materials, textures;  // textures: version 6
  };

  void read_model(const FbxNode& model) {
    const int64_t id = scene_.id_of(model);
    Slots slots;
    std::vector<const FbxNode*> geometries;
    for (const FbxLink& link : scene_.parts_of(id)) {
      if (const FbxNode* material = scene_.object_of(link.other, "Material"))
        slots.materials.push_back(material);
      if (const FbxNode* texture = scene_.object_of(link.other, "Texture")) slots.textures.push_back(texture);
      const FbxNode* geometry = scene_.object_of(link.other, "Geometry");
      if (geometry && geometry->child("PolygonVertexIndex")) geometries.push_back(geometry);
    }
    if (scene_.is_version_6() && model.child("PolygonVertexIndex")) geometries.push_back(&model);
    if (geometries.empty()) return;
    const Affine placed = world_of(model) * fbx_geometric_transform(FbxProperties(fbx_, model));
    const std::string name = scene_.name_of(model);
    for (const FbxNode* geometry : geometries)
      read_geometry(*geometry, "mesh '" + name + "'", placed, group_of(name), slots);
  }

  size_t group_of(const std::string& name) {
    const auto [found, is_new] = groups_.emplace(name, scan_.groups.size());
    if (is_new) scan_.groups.push_back(name);
    if (scan_.groups.size() > kMaxScanNames) fbx_.fail("Objects", "has too many models", "join some of them");
    return found->second;
  }

  void check_room(size_t count, const std::string& place) const {
    if (count > kMaxScanElements)
      fbx_.fail(place, "brings the scan to " + std::to_string(count) + " elements",
                "a scan may have " + std::to_string(kMaxScanElements));
  }

  void read_geometry(const FbxNode& geometry, const std::string& place, const Affine& placed, size_t group,
                     const Slots& slots) {
    const size_t base = positions_.size(), first_face = scan_.face_begin.size();
    const size_t first_corner = scan_.corners.size();
    read_positions(geometry, place, placed);
    if (geometry.child("LayerElementNormal")) scan_.has_file_normals = true;
    read_polygons(geometry, place, base, group);
    read_uvs(geometry, place, base, first_corner);
    read_face_materials(geometry, place, first_face, slots);
    read_colours(geometry, place, base, first_face);
    if (determinant(placed) >= 0) return;
    for (size_t f = first_face; f < scan_.face_begin.size(); ++f) {
      const auto begin = static_cast<std::ptrdiff_t>(scan_.face_begin[f]), end = end_of_face(f);
      std::reverse(scan_.corners.begin() + begin + 1, scan_.corners.begin() + end);
      if (scan_.corner_colours.size() == scan_.corners.size())
        std::reverse(scan_.corner_colours.begin() + begin + 1, scan_.corner_colours.begin() + end);
    }
  }

  /// Also of the last face, which is not closed yet.
  std::ptrdiff_t end_of_face(size_t face) const {
    return static_cast<std::ptrdiff_t>(face + 1 < scan_.face_begin.size() ? scan_.face_begin[face + 1]
                                                                          : scan_.corners.size());
  }

  void read_positions(const FbxNode& geometry, const std::string& place, const Affine& placed) {
    const FbxNode* vertices = geometry.child("Vertices");
    if (!vertices) fbx_.fail(place, "has no Vertices", kExportAgain);
    const std::vector<double> xyz = fbx_.numbers(*vertices);
    check_room(positions_.size() + xyz.size() / 3, place);
    std::vector<Vec3d> own;
    for (size_t i = 0; i + 2 < xyz.size(); i += 3) own.push_back({xyz[i], xyz[i + 1], xyz[i + 2]});
    apply_fbx_shapes(scene_, geometry, place, own, scan_.notes);
    for (size_t i = 0; i < own.size(); ++i) {
      const Vec3d p = transformed(placed, own[i]);
      if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
        fbx_.fail(place, numbered("vertex", i) + " is not finite", "remove the vertex and its faces");
      positions_.push_back(p);
    }
  }

  /// The last corner of each polygon is stored as its complement.
  void read_polygons(const FbxNode& geometry, const std::string& place, size_t base, size_t group) {
    const std::vector<double> indices = fbx_.numbers(*geometry.child("PolygonVertexIndex"));
    const double vertex_count = static_cast<double>(positions_.size() - base);
    check_room(scan_.corners.size() + indices.size(), place);
    bool starts = true;
    for (size_t i = 0; i < indices.size(); ++i) {
      if (starts) begin_face(scan_, 0, group);
      starts = indices[i] < 0;
      const double index = starts ? -indices[i] - 1 : indices[i];
      if (!(index < vertex_count))
        fbx_.fail(place,
                  "corner " + std::to_string(i + 1) + " names vertex " +
                      std::to_string(static_cast<int64_t>(index) + 1) + " of " +
                      std::to_string(positions_.size() - base),
                  kExportAgain);
      scan_.corners.push_back({static_cast<uint32_t>(base + static_cast<size_t>(index)), Corner::kNoUv});
    }
    if (!starts) fbx_.fail(place, "ends within a polygon", kExportAgain);
  }

  /// The first layer of that kind; no values if the mesh has none.
  Layer layer_of(const FbxNode& geometry, const char* kind, const char* values, const char* index) const {
    Layer layer;
    const FbxNode* node = geometry.child(kind);
    const FbxNode* value_node = node ? node->child(values) : nullptr;
    if (!value_node || value_node->values.empty()) return layer;
    layer.values = fbx_.numbers(*value_node);
    if (const FbxNode* mapping = node->child("MappingInformationType"))
      layer.mapping = fbx_.text(*mapping, 0);
    const FbxNode* index_node = node->child(index);
    if (index_node && !index_node->values.empty()) {
      layer.index = fbx_.numbers(*index_node);
      layer.has_index = true;
    }
    return layer;
  }

  void read_uvs(const FbxNode& geometry, const std::string& place, size_t base, size_t first_corner) {
    const Layer layer = layer_of(geometry, "LayerElementUV", "UV", "UVIndex");
    const std::vector<double>& uv = layer.values;
    if (uv.empty()) return;
    if (!layer.is_by_vertex() && layer.mapping != "ByPolygonVertex")
      fbx_.fail(place, "has UVs mapped '" + layer.mapping + "'", kExportAgain);
    const size_t uv_base = scan_.uvs.size();
    check_room(uv_base + uv.size() / 2, place);
    for (size_t i = 0; i + 1 < uv.size(); i += 2) {
      scan_.uvs.push_back({static_cast<float>(uv[i]), static_cast<float>(uv[i + 1])});
      if (!is_finite(scan_.uvs.back()))
        fbx_.fail(place, numbered("UV", i / 2) + " is not finite", "unwrap its faces again");
    }
    for (size_t c = first_corner; c < scan_.corners.size(); ++c) {
      const double target =
          layer.at(layer.is_by_vertex() ? scan_.corners[c].position - base : c - first_corner);
      if (target == -1) continue;  // a corner without UV
      if (!(target >= 0 && target < static_cast<double>(uv.size() / 2)))
        fbx_.fail(place, "corner " + std::to_string(c - first_corner + 1) + " has a UV index out of range",
                  kExportAgain);
      scan_.corners[c].uv = static_cast<uint32_t>(uv_base + static_cast<size_t>(target));
    }
  }

  void read_face_materials(const FbxNode& geometry, const std::string& place, size_t first_face,
                           const Slots& slots) {
    if (slots.textures.empty())  // materials that no face uses are listed too, in the order of the slots
      for (const FbxNode* slot : slots.materials) materials_.index_of(slot);
    const std::vector<double> material =
        numbers_of_faces(geometry, "LayerElementMaterial", "Materials", first_face, place);
    const std::vector<double> texture =
        slots.textures.empty()
            ? std::vector<double>()
            : numbers_of_faces(geometry, "LayerElementTexture", "TextureId", first_face, place);
    const auto node_at = [](const std::vector<const FbxNode*>& nodes, double slot) {
      return slot >= 0 && slot < static_cast<double>(nodes.size()) ? nodes[static_cast<size_t>(slot)]
                                                                   : nullptr;
    };
    for (size_t f = first_face; f < scan_.face_begin.size(); ++f)
      scan_.face_material[f] = static_cast<uint16_t>(
          materials_.index_of(node_at(slots.materials, material[f - first_face]),
                              texture.empty() ? nullptr : node_at(slots.textures, texture[f - first_face])));
  }

  /// One number a face: the layer's, or the first of what it names for all; 0 without a layer.
  std::vector<double> numbers_of_faces(const FbxNode& geometry, const char* kind, const char* values,
                                       size_t first_face, const std::string& place) const {
    const Layer layer = layer_of(geometry, kind, values, "");
    const size_t face_count = scan_.face_begin.size() - first_face;
    if (layer.mapping != "ByPolygon")
      return std::vector<double>(face_count,
                                 layer.mapping == "AllSame" && !layer.values.empty() ? layer.values[0] : 0);
    if (layer.values.size() != face_count)
      fbx_.fail(place,
                "has " + std::to_string(layer.values.size()) + " material indices for " +
                    std::to_string(face_count) + " faces",
                kExportAgain);
    return layer.values;
  }

  /// sRGB, as Blender takes them. Layers all white or all black are what programs write that have no colours.
  void read_colours(const FbxNode& geometry, const std::string& place, size_t base, size_t first_face) {
    const Layer layer = layer_of(geometry, "LayerElementColor", "Colors", "ColorIndex");
    const std::vector<double>& rgba = layer.values;
    bool all_white = true, all_black = true;
    for (size_t i = 0; i < rgba.size(); ++i) {
      all_white = all_white && (i % 4 == 3 || rgba[i] >= 1);
      all_black = all_black && (i % 4 == 3 || rgba[i] == 0);
    }
    if (all_white || first_face == scan_.face_begin.size()) return;
    const bool is_by_face = layer.mapping == "ByPolygon", is_one = layer.mapping == "AllSame";
    const bool is_known = is_by_face || is_one || layer.is_by_vertex() || layer.mapping == "ByPolygonVertex";
    if (all_black || !is_known) {
      scan_.notes.push_back(place + ": its colours at the vertices are " +
                            (all_black ? "all black and" : "mapped '" + layer.mapping + "' and") +
                            " not used");
      return;
    }
    scan_.corner_colours.resize(scan_.corners.size());
    is_coloured_.resize(scan_.face_begin.size(), false);
    const size_t first_corner = scan_.face_begin[first_face];
    for (size_t f = first_face; f < scan_.face_begin.size(); ++f) {
      is_coloured_[f] = true;
      for (auto c = scan_.face_begin[f]; c < static_cast<size_t>(end_of_face(f)); ++c) {
        const double target = layer.at(is_one                 ? 0
                                       : is_by_face           ? f - first_face
                                       : layer.is_by_vertex() ? scan_.corners[c].position - base
                                                              : c - first_corner);
        if (target == -1) continue;
        if (!(target >= 0 && target < static_cast<double>(rgba.size() / 4)))
          fbx_.fail(place, "corner " + std::to_string(c - first_corner + 1) + " has a colour out of range",
                    kExportAgain);
        const double* const colour = &rgba[4 * static_cast<size_t>(target)];
        for (int k = 0; k < 3; ++k)
          scan_.corner_colours[c].rgb[k] =
              srgb_to_linear(static_cast<float>(std::clamp(colour[k], 0.0, 1.0)));
      }
    }
  }

  FbxScene scene_;
  const FbxFile& fbx_;
  Scan scan_;
  ScanFiles files_;
  FbxMaterials materials_;
  std::vector<Vec3d> positions_;
  std::vector<bool> is_coloured_;  // by face
  Affine to_y_up_;
  std::unordered_map<std::string, size_t> groups_;
};

}  // namespace

Scan read_fbx(const std::filesystem::path& file) {
  return FbxReader(file).read();
}

}  // namespace ohb
