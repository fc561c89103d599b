// glTF 2.0 (.glb, .gltf): triangles of the default scene, node transforms applied, pose at rest.
// Our UVs have v up, glTF's have v down. The unit is the metre.
#include <array>
#include <cmath>

#include "dataset/model/affine.h"
#include "dataset/model/error.h"
#include "dataset/model/gltf_file.h"
#include "dataset/model/scan_readers.h"

namespace ohb {
namespace {

using nlohmann::json;

template <size_t N>
std::array<double, N> numbers(const json& object, const char* key, std::array<double, N> missing) {
  const auto found = object.find(key);
  return found == object.end() ? missing : found->get<std::array<double, N>>();
}

Affine local_transform(const json& node) {
  Affine a;
  if (node.contains("matrix")) {
    const auto m = numbers<16>(node, "matrix", {});
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 4; ++j) a(i, j) = m[static_cast<size_t>(j * 4 + i)];
    return a;
  }
  const auto t = numbers<3>(node, "translation", {0, 0, 0});
  const auto q = numbers<4>(node, "rotation", {0, 0, 0, 1});
  const auto s = numbers<3>(node, "scale", {1, 1, 1});
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

class GltfReader {
 public:
  explicit GltfReader(const std::filesystem::path& file) : gltf_(file), files_(scan_) {
    scan_.file = file;
    scan_.stated_unit_cm = 100;
  }

  Scan read() {
    check_extensions();
    for (size_t i = 0; i < gltf_.count("materials"); ++i) read_material(i);
    read_nodes();
    close_faces(scan_);
    if (scan_.materials.empty()) scan_.materials.emplace_back().name = "default";
    if (scan_.groups.empty()) scan_.groups.push_back("default");
    return std::move(scan_);
  }

 private:
  /// Where a material takes a picture's UVs from; all of a material's pictures share it.
  struct MaterialUv {
    size_t set = 0;
    bool is_set = false;
  };

  void check_extensions() const {
    if (!gltf_.root().contains("extensionsRequired")) return;
    for (const json& name : gltf_.root().at("extensionsRequired")) {
      const std::string extension = name.get<std::string>();
      if (extension != "KHR_mesh_quantization" && extension != "KHR_materials_unlit" &&
          extension != "KHR_texture_transform")
        gltf_.fail("extensionsRequired", "needs " + extension, "export without compression and extensions");
    }
  }

  ScanPicture read_texture(const json& info, const std::string& place, MaterialUv& uv) {
    const size_t set = index_or(info, "texCoord", 0);
    if (uv.is_set && set != uv.set)
      gltf_.fail(place, "uses several UV layouts", "give its pictures one UV layout");
    uv = {set, true};
    if (info.contains("extensions") && info.at("extensions").contains("KHR_texture_transform"))
      gltf_.fail(place, "moves or scales its picture", "apply the texture transform to the UVs");
    const size_t source = index_or(gltf_.item("textures", index_or(info, "index")), "source");
    if (source == kMissing)
      gltf_.fail(place, "has a texture without a picture this version reads", "export PNG or JPEG pictures");
    return read_picture(source);
  }

  ScanPicture read_picture(size_t index) {
    const auto known = pictures_.find(index);
    if (known != pictures_.end()) return known->second;
    const json& image = gltf_.item("images", index);
    const std::string place = "images[" + std::to_string(index) + "]";
    const std::string label = "image" + std::to_string(index);
    ScanPicture picture;
    if (image.contains("uri")) {
      const std::string uri = image.at("uri").get<std::string>();
      std::string bytes;
      picture = gltf_.decode_data_uri(uri, place, bytes)
                    ? embed_picture(gltf_.path(), label, std::move(bytes))
                    : files_.picture(gltf_.path(), place, {decode_percent(uri)});
    } else {
      picture =
          embed_picture(gltf_.path(), label, std::string(gltf_.buffer_view(index_or(image, "bufferView"))));
    }
    return pictures_[index] = picture;
  }

  void read_material(size_t index) {
    const json& from = gltf_.item("materials", index);
    const std::string place = "materials[" + std::to_string(index) + "]";
    ScanMaterial material;
    MaterialUv uv;
    material.name = from.value("name", "material" + std::to_string(index));
    const json surface = from.value("pbrMetallicRoughness", json::object());
    const auto factor = numbers<4>(surface, "baseColorFactor", {1, 1, 1, 1});
    for (double value : factor)
      if (!(value >= 0 && value < 1e6))
        gltf_.fail(place, "has a colour factor that is no colour", "correct it");
    material.diffuse_factor = {static_cast<float>(factor[0]), static_cast<float>(factor[1]),
                               static_cast<float>(factor[2])};
    if (surface.contains("baseColorTexture"))
      material.diffuse = read_texture(surface.at("baseColorTexture"), place, uv);
    if (from.contains("normalTexture")) {
      material.normal = read_texture(from.at("normalTexture"), place, uv);
      if (from.at("normalTexture").value("scale", 1.0) != 1.0)
        scan_.notes.push_back(place + ": the normal map's scale is not used");
    }
    if (from.value("alphaMode", "OPAQUE") != "OPAQUE" && !material.diffuse.empty() &&
        probe_image(material.diffuse).has_alpha)
      material.alpha = material.diffuse;
    scan_.materials.push_back(material);
    uv_sets_.push_back(uv.set);
  }

  /// Pre-order walk from the scene's roots without recursion; a node that comes twice is an error.
  void read_nodes() {
    struct Visit {
      size_t node;
      Affine parent;
    };
    std::vector<Visit> stack;
    const std::vector<size_t> roots = scene_roots();
    for (auto root = roots.rbegin(); root != roots.rend(); ++root) stack.push_back({*root, Affine()});
    std::vector<bool> seen(gltf_.count("nodes"), false);
    while (!stack.empty()) {
      const Visit visit = stack.back();
      stack.pop_back();
      const json& node = gltf_.item("nodes", visit.node);
      if (seen[visit.node])
        gltf_.fail("nodes[" + std::to_string(visit.node) + "]", "has two parents or is its own ancestor",
                   "export the scene again");
      seen[visit.node] = true;
      const Affine world = visit.parent * local_transform(node);
      if (node.contains("mesh")) read_mesh(node, visit.node, world);
      const json children = node.value("children", json::array());
      for (size_t i = children.size(); i-- > 0;) stack.push_back({children[i].get<size_t>(), world});
    }
  }

  std::vector<size_t> scene_roots() const {
    if (gltf_.count("scenes") > 0)
      return gltf_.item("scenes", index_or(gltf_.root(), "scene", 0)).value("nodes", std::vector<size_t>());
    std::vector<bool> is_child(gltf_.count("nodes"), false);
    for (size_t i = 0; i < is_child.size(); ++i)
      for (size_t child : gltf_.item("nodes", i).value("children", std::vector<size_t>()))
        if (child < is_child.size()) is_child[child] = true;
    std::vector<size_t> roots;
    for (size_t i = 0; i < is_child.size(); ++i)
      if (!is_child[i]) roots.push_back(i);
    return roots;
  }

  void read_mesh(const json& node, size_t node_index, const Affine& world) {
    const size_t mesh_index = index_or(node, "mesh");
    const json& mesh = gltf_.item("meshes", mesh_index);
    Affine placed = world;
    if (node.contains("skin")) {
      placed = Affine();  // a skinned mesh ignores its node's transform
      scan_.notes.push_back("the mesh is rigged: its pose at rest is used");
    }
    const std::string name = node.value("name", mesh.value("name", "node" + std::to_string(node_index)));
    const size_t group = group_of(name);
    const size_t first_position = scan_.positions.size(), first_corner = scan_.corners.size();
    const json& primitives = mesh.at("primitives");
    for (size_t p = 0; p < primitives.size(); ++p)
      read_primitive(primitives.at(p),
                     "meshes[" + std::to_string(mesh_index) + "].primitives[" + std::to_string(p) + "]",
                     placed, group);
    weld_positions(scan_, first_position, first_corner);
  }

  size_t group_of(const std::string& name) {
    const auto [found, is_new] = groups_.emplace(name, scan_.groups.size());
    if (is_new) scan_.groups.push_back(name);
    if (scan_.groups.size() > kMaxScanNames) gltf_.fail("nodes", "has too many objects", "join some of them");
    return found->second;
  }

  void read_primitive(const json& primitive, const std::string& place, const Affine& world, size_t group) {
    const size_t mode = index_or(primitive, "mode", 4);
    if (mode < 4) return;  // points and lines
    if (mode > 6) gltf_.fail(place, "has the unknown mode " + std::to_string(mode), "export triangles");
    const json& attributes = primitive.at("attributes");
    const size_t position_accessor = index_or(attributes, "POSITION");
    if (position_accessor == kMissing) gltf_.fail(place, "has no POSITION", "export the scan again");
    if (attributes.contains("NORMAL")) scan_.has_file_normals = true;
    const size_t material = material_of(primitive, place);
    const auto base = static_cast<uint32_t>(scan_.positions.size());
    add_positions(gltf_.floats(position_accessor, 3), place, world);
    const size_t vertex_count = scan_.positions.size() - base;
    const size_t uv_accessor =
        index_or(attributes, ("TEXCOORD_" + std::to_string(uv_sets_.at(material))).c_str());
    const uint32_t uv_base = add_uvs(uv_accessor, vertex_count, place);
    std::vector<uint32_t> order;
    if (primitive.contains("indices")) {
      order = gltf_.indices(index_or(primitive, "indices"));
    } else {
      order.resize(vertex_count);
      for (size_t i = 0; i < vertex_count; ++i) order[i] = static_cast<uint32_t>(i);
    }
    for (size_t i = 0; i < order.size(); ++i)
      if (order[i] >= vertex_count)
        gltf_.fail(place,
                   "index " + std::to_string(i) + " is " + std::to_string(order[i]) + " but it has " +
                       std::to_string(vertex_count) + " vertices",
                   "export the scan again");
    add_triangles(order, mode, material, group, determinant(world) < 0, base, uv_base, place);
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
    }
    return default_material_;
  }

  void add_positions(const std::vector<float>& values, const std::string& place, const Affine& world) {
    check_room(scan_.positions.size() + values.size() / 3, place);
    for (size_t i = 0; i + 2 < values.size(); i += 3) {
      const Vec3f p = transformed(world, values[i], values[i + 1], values[i + 2]);
      if (!is_finite(p))
        gltf_.fail(place, numbered("vertex", i / 3) + " is not finite", "remove the vertex and its faces");
      scan_.positions.push_back(p);
    }
  }

  /// Index of the first added UV; kNoUv if the primitive has none.
  uint32_t add_uvs(size_t accessor, size_t vertex_count, const std::string& place) {
    if (accessor == kMissing) return Corner::kNoUv;
    const auto base = static_cast<uint32_t>(scan_.uvs.size());
    const std::vector<float> values = gltf_.floats(accessor, 2);
    if (values.size() != 2 * vertex_count)
      gltf_.fail(place,
                 "has " + std::to_string(values.size() / 2) + " UVs for " + std::to_string(vertex_count) +
                     " vertices",
                 "export the scan again");
    check_room(scan_.uvs.size() + vertex_count, place);
    for (size_t i = 0; i + 1 < values.size(); i += 2) {
      scan_.uvs.push_back({values[i], 1.0f - values[i + 1]});
      if (!is_finite(scan_.uvs.back()))
        gltf_.fail(place, numbered("UV", i / 2) + " is not finite", "unwrap its faces again");
    }
    return base;
  }

  void add_triangles(const std::vector<uint32_t>& order, size_t mode, size_t material, size_t group,
                     bool mirrored, uint32_t base, uint32_t uv_base, const std::string& place) {
    if (mode == 4 && order.size() % 3 != 0)
      gltf_.fail(place, "has " + std::to_string(order.size()) + " indices, which is no multiple of 3",
                 "export the scan again");
    if (order.size() < 3) return;
    const size_t count = mode == 4 ? order.size() / 3 : order.size() - 2;
    check_room(scan_.corners.size() + 3 * count, place);
    for (size_t t = 0; t < count; ++t) {
      std::array<size_t, 3> at{t, t + 1, t + 2};
      if (mode == 4) at = {3 * t, 3 * t + 1, 3 * t + 2};
      if (mode == 6) at[0] = 0;
      if ((mode == 5 && t % 2 == 1) != mirrored) std::swap(at[1], at[2]);
      begin_face(scan_, material, group);
      for (size_t i : at)
        scan_.corners.push_back(
            {base + order[i], uv_base == Corner::kNoUv ? Corner::kNoUv : uv_base + order[i]});
    }
  }

  void check_room(size_t count, const std::string& place) const {
    if (count > kMaxScanElements)
      gltf_.fail(place, "brings the scan to " + std::to_string(count) + " elements",
                 "a scan may have " + std::to_string(kMaxScanElements));
  }

  GltfFile gltf_;
  Scan scan_;
  ScanFiles files_;
  std::map<size_t, ScanPicture> pictures_;
  std::map<std::string, size_t> groups_;
  std::vector<size_t> uv_sets_;  // of each material
  size_t default_material_ = kMissing;
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
