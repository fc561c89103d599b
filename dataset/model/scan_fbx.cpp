// FBX 7: meshes of the scene with their polygons in file order, node transforms applied, pose at rest, the
// file's stated up axis turned to +Y. The unit is what the file states (UnitScaleFactor, cm).
#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

#include "dataset/model/affine.h"
#include "dataset/model/error.h"
#include "dataset/model/fbx_file.h"
#include "dataset/model/fbx_transform.h"
#include "dataset/model/scan_readers.h"

namespace ohb {
namespace {

constexpr const char* kExportAgain = "export the scan again";

struct Link {
  int64_t other = 0;
  std::string property;  // of "OP" connections
};

class FbxReader {
 public:
  explicit FbxReader(const std::filesystem::path& file) : fbx_(file), files_(scan_) { scan_.file = file; }

  Scan read() {
    index_objects();
    read_settings();
    const FbxNode& objects = *fbx_.root().child("Objects");
    for (const FbxNode& object : objects.children) {
      if (object.name == "Model" && !object.values.empty()) read_model(object);
      if (object.name == "Deformer") has_deformer_ = true;
    }
    close_faces(scan_);
    if (has_deformer_) scan_.notes.push_back("the mesh is rigged: its pose at rest is used");
    if (scan_.materials.empty()) scan_.materials.emplace_back().name = "default";
    if (scan_.groups.empty()) scan_.groups.push_back("default");
    return std::move(scan_);
  }

 private:
  void index_objects() {
    const FbxNode* objects = fbx_.root().child("Objects");
    if (!objects) fbx_.fail("Objects", "are missing", kExportAgain);
    for (const FbxNode& object : objects->children)
      if (!object.values.empty()) objects_.emplace(fbx_.integer(object, 0), &object);
    const FbxNode* connections = fbx_.root().child("Connections");
    if (!connections) return;
    for (const FbxNode& c : connections->children) {
      if (c.values.size() < 3) continue;
      const int64_t from = fbx_.integer(c, 1), to = fbx_.integer(c, 2);
      const std::string property = c.values.size() > 3 ? fbx_.text(c, 3) : "";
      parts_[to].push_back({from, property});
      wholes_[from].push_back({to, property});
    }
  }

  void read_settings() {
    const FbxNode* settings = fbx_.root().child("GlobalSettings");
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

  const FbxNode* object_of(int64_t id, std::string_view kind) const {
    const auto found = objects_.find(id);
    return found != objects_.end() && found->second->name == kind ? found->second : nullptr;
  }

  const std::vector<Link>& parts_of(int64_t id) const {
    static const std::vector<Link> none;
    const auto found = parts_.find(id);
    return found == parts_.end() ? none : found->second;
  }

  /// Binary files write "name\0\1Class", ASCII ones "Class::name".
  std::string name_of(const FbxNode& object) const {
    std::string name = object.values.size() > 1 ? fbx_.text(object, 1) : "";
    const size_t zero = name.find('\0');
    if (zero != std::string::npos) name.resize(zero);
    const size_t colons = name.find("::");
    if (colons != std::string::npos) name.erase(0, colons + 2);
    return name.empty() ? std::string(object.name) : name;
  }

  Affine world_of(int64_t model_id) const {
    Affine world;
    int64_t id = model_id;
    for (int depth = 0;; ++depth) {
      const FbxNode* model = object_of(id, "Model");
      if (!model) return to_y_up_ * world;
      if (depth > 1000) fbx_.fail("Connections", "make a node its own ancestor", kExportAgain);
      world = fbx_local_transform(FbxProperties(fbx_, *model)) * world;
      const auto parents = wholes_.find(id);
      id = 0;
      if (parents != wholes_.end())
        for (const Link& parent : parents->second)
          if (object_of(parent.other, "Model")) id = parent.other;
    }
  }

  void read_model(const FbxNode& model) {
    const int64_t id = fbx_.integer(model, 0);
    std::vector<size_t> materials;
    std::vector<const FbxNode*> geometries;
    for (const Link& link : parts_of(id)) {
      if (const FbxNode* material = object_of(link.other, "Material"))
        materials.push_back(material_of(*material));
      const FbxNode* geometry = object_of(link.other, "Geometry");
      if (geometry && geometry->child("PolygonVertexIndex")) geometries.push_back(geometry);
    }
    if (geometries.empty()) return;
    const Affine placed = world_of(id) * fbx_geometric_transform(FbxProperties(fbx_, model));
    const size_t group = group_of(name_of(model));
    for (const FbxNode* geometry : geometries)
      read_geometry(*geometry, name_of(model), placed, group, materials);
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

  void read_geometry(const FbxNode& geometry, const std::string& name, const Affine& placed, size_t group,
                     const std::vector<size_t>& materials) {
    const std::string place = "mesh '" + name + "'";
    const size_t base = scan_.positions.size(), first_face = scan_.face_begin.size();
    const size_t first_corner = scan_.corners.size();
    const FbxNode* vertices = geometry.child("Vertices");
    if (!vertices) fbx_.fail(place, "has no Vertices", kExportAgain);
    const std::vector<double> xyz = fbx_.numbers(*vertices);
    check_room(base + xyz.size() / 3, place);
    for (size_t i = 0; i + 2 < xyz.size(); i += 3) {
      const Vec3f p = transformed(placed, xyz[i], xyz[i + 1], xyz[i + 2]);
      if (!is_finite(p))
        fbx_.fail(place, numbered("vertex", i / 3) + " is not finite", "remove the vertex and its faces");
      scan_.positions.push_back(p);
    }
    if (geometry.child("LayerElementNormal")) scan_.has_file_normals = true;
    read_polygons(geometry, place, base, group);
    read_uvs(geometry, place, base, first_corner);
    read_face_materials(geometry, place, first_face, materials);
    if (determinant(placed) < 0)
      for (size_t f = first_face; f < scan_.face_begin.size(); ++f)
        std::reverse(corner_at(f) + 1, corner_at(f + 1));
  }

  std::vector<Corner>::iterator corner_at(size_t face) {
    const bool last = face >= scan_.face_begin.size();
    return scan_.corners.begin() + (last ? static_cast<std::ptrdiff_t>(scan_.corners.size())
                                         : static_cast<std::ptrdiff_t>(scan_.face_begin[face]));
  }

  /// The last corner of each polygon is stored as its complement.
  void read_polygons(const FbxNode& geometry, const std::string& place, size_t base, size_t group) {
    const std::vector<double> indices = fbx_.numbers(*geometry.child("PolygonVertexIndex"));
    const double vertex_count = static_cast<double>(scan_.positions.size() - base);
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
                      std::to_string(scan_.positions.size() - base),
                  kExportAgain);
      scan_.corners.push_back({static_cast<uint32_t>(base + static_cast<size_t>(index)), Corner::kNoUv});
    }
    if (!starts) fbx_.fail(place, "ends within a polygon", kExportAgain);
  }

  void read_uvs(const FbxNode& geometry, const std::string& place, size_t base, size_t first_corner) {
    const FbxNode* layer = geometry.child("LayerElementUV");
    const FbxNode* values = layer ? layer->child("UV") : nullptr;
    if (!values) return;
    const FbxNode* mapping = layer->child("MappingInformationType");
    const std::string kind = mapping ? fbx_.text(*mapping, 0) : "ByPolygonVertex";
    const bool by_vertex = kind == "ByVertice" || kind == "ByVertex";
    if (!by_vertex && kind != "ByPolygonVertex")
      fbx_.fail(place, "has UVs mapped '" + kind + "'", kExportAgain);
    const std::vector<double> uv = fbx_.numbers(*values);
    const FbxNode* index_node = layer->child("UVIndex");
    const std::vector<double> index = index_node ? fbx_.numbers(*index_node) : std::vector<double>();
    const size_t uv_base = scan_.uvs.size();
    check_room(uv_base + uv.size() / 2, place);
    for (size_t i = 0; i + 1 < uv.size(); i += 2) {
      scan_.uvs.push_back({static_cast<float>(uv[i]), static_cast<float>(uv[i + 1])});
      if (!is_finite(scan_.uvs.back()))
        fbx_.fail(place, numbered("UV", i / 2) + " is not finite", "unwrap its faces again");
    }
    for (size_t c = first_corner; c < scan_.corners.size(); ++c) {
      const size_t item = by_vertex ? scan_.corners[c].position - base : c - first_corner;
      const double target = !index_node ? static_cast<double>(item) : item < index.size() ? index[item] : -2;
      if (target == -1) continue;  // a corner without UV
      if (!(target >= 0 && target < static_cast<double>(uv.size() / 2)))
        fbx_.fail(place, "corner " + std::to_string(c - first_corner + 1) + " has a UV index out of range",
                  kExportAgain);
      scan_.corners[c].uv = static_cast<uint32_t>(uv_base + static_cast<size_t>(target));
    }
  }

  void read_face_materials(const FbxNode& geometry, const std::string& place, size_t first_face,
                           const std::vector<size_t>& materials) {
    const FbxNode* layer = geometry.child("LayerElementMaterial");
    const FbxNode* values = layer ? layer->child("Materials") : nullptr;
    const FbxNode* mapping = layer ? layer->child("MappingInformationType") : nullptr;
    const bool by_polygon = values && mapping && fbx_.text(*mapping, 0) == "ByPolygon";
    const std::vector<double> slots = by_polygon ? fbx_.numbers(*values) : std::vector<double>();
    const size_t face_count = scan_.face_begin.size() - first_face;
    if (by_polygon && slots.size() != face_count)
      fbx_.fail(place,
                "has " + std::to_string(slots.size()) + " material indices for " +
                    std::to_string(face_count) + " faces",
                kExportAgain);
    for (size_t f = 0; f < face_count; ++f) {
      const double slot = by_polygon ? slots[f] : 0;
      const bool known = slot >= 0 && slot < static_cast<double>(materials.size());
      scan_.face_material[first_face + f] =
          static_cast<uint16_t>(known ? materials[static_cast<size_t>(slot)] : default_material());
    }
  }

  size_t default_material() {
    if (!default_material_) {
      default_material_ = scan_.materials.size();
      scan_.materials.emplace_back().name = "default";
    }
    return *default_material_;
  }

  size_t material_of(const FbxNode& node) {
    const int64_t id = fbx_.integer(node, 0);
    const auto found = materials_.find(id);
    if (found != materials_.end()) return found->second;
    ScanMaterial material;
    material.name = name_of(node);
    const auto colour = FbxProperties(fbx_, node).vector("DiffuseColor", {1, 1, 1});
    for (double value : colour)
      if (!(value >= 0 && value < 1e6))
        fbx_.fail("material '" + material.name + "'", "has no colour", "correct it");
    material.diffuse_factor = {static_cast<float>(colour[0]), static_cast<float>(colour[1]),
                               static_cast<float>(colour[2])};
    for (const Link& link : parts_of(id))
      if (const FbxNode* texture = object_of(link.other, "Texture"))
        set_picture(material, link.property, *texture);
    if (!material.diffuse.empty()) material.diffuse_factor = {1, 1, 1};
    if (scan_.materials.size() >= kMaxScanNames)
      fbx_.fail("Objects", "has too many materials", "join some of them");
    scan_.materials.push_back(material);
    return materials_[id] = scan_.materials.size() - 1;
  }

  /// Exporters name the slot in their own ways: the last part of "3dsMax|Parameters|base_color_map" counts.
  void set_picture(ScanMaterial& material, const std::string& property, const FbxNode& texture) {
    const std::string slot =
        property.substr(property.rfind('|') == std::string::npos ? 0 : property.rfind('|') + 1);
    const auto is_one_of = [&](std::initializer_list<const char*> names) {
      return std::any_of(names.begin(), names.end(), [&](const char* name) { return slot == name; });
    };
    if (is_one_of({"DiffuseColor", "base_color_map", "baseColor", "TEX_color_map", "diffuse_map"})) {
      material.diffuse = picture_of(texture);
    } else if (is_one_of({"NormalMap", "normal_map", "norm_map", "normalCamera", "TEX_normal_map"})) {
      material.normal = picture_of(texture);
    } else if (is_one_of(
                   {"TransparentColor", "TransparencyFactor", "Opacity", "opacity_map", "cutout_map"})) {
      material.alpha = picture_of(texture);
    } else if (slot == "Bump") {
      const ScanPicture picture = picture_of(texture);
      if (picture.empty()) return;
      if (!is_normal_map(picture)) {
        scan_.notes.push_back(picture.file.filename().string() + " is a grey height map, which is not used");
      } else if (material.normal.empty()) {
        material.normal = picture;
      }
    }
  }

  ScanPicture picture_of(const FbxNode& texture) {
    const std::string place = "texture '" + name_of(texture) + "'";
    const int64_t id = fbx_.integer(texture, 0);
    const auto known = pictures_.find(id);
    if (known != pictures_.end()) return known->second;
    for (const Link& link : parts_of(id)) {
      const FbxNode* video = object_of(link.other, "Video");
      const FbxNode* content = video ? video->child("Content") : nullptr;
      if (!content || content->values.empty() || content->values[0].type == 'T') continue;
      if (content->values[0].type == 'S')
        fbx_.fail(place, "is embedded in an ASCII file, which is not supported", "export as binary FBX");
      std::string bytes = fbx_.text(*content, 0);
      if (!bytes.empty())
        return pictures_[id] = embed_picture(fbx_.path(), name_of(*video), std::move(bytes));
    }
    return pictures_[id] = find_beside(texture, place);
  }

  /// FBX keeps the paths of the machine that wrote it, in the texture and in its video.
  ScanPicture find_beside(const FbxNode& texture, const std::string& place) {
    std::vector<std::string> names;
    const auto add_names = [&](const FbxNode& node) {
      for (const char* key : {"RelativeFilename", "FileName", "Filename"}) {
        const FbxNode* name = node.child(key);
        if (!name || name->values.empty()) continue;
        names.push_back(fbx_.text(*name, 0));
        if (names.back().empty()) names.pop_back();
      }
    };
    add_names(texture);
    for (const Link& link : parts_of(fbx_.integer(texture, 0)))
      if (const FbxNode* video = object_of(link.other, "Video")) add_names(*video);
    if (!names.empty()) return files_.picture(fbx_.path(), place, names);
    scan_.notes.push_back(place + " names no picture");
    return {};
  }

  FbxFile fbx_;
  Scan scan_;
  ScanFiles files_;
  Affine to_y_up_;
  std::unordered_map<int64_t, const FbxNode*> objects_;
  std::unordered_map<int64_t, std::vector<Link>> parts_, wholes_;  // children, parents
  std::unordered_map<int64_t, size_t> materials_;
  std::unordered_map<int64_t, ScanPicture> pictures_;
  std::unordered_map<std::string, size_t> groups_;
  std::optional<size_t> default_material_;
  bool has_deformer_ = false;
};

}  // namespace

Scan read_fbx(const std::filesystem::path& file) {
  return FbxReader(file).read();
}

}  // namespace ohb
