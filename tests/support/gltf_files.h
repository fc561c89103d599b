// GLB files that tests put together: a square of two triangles, and what a test adds to it.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/scan_files.h"

namespace ohb {

/// The square [0,1] x [0,1] in the plane z = 0, UVs as its positions (v up), with one material that has no
/// picture yet. Everything is in `json` and `binary`.
class GlbBuilder {
 public:
  nlohmann::json json;
  std::string binary;

  GlbBuilder() {
    json = nlohmann::json::parse(
        R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"name":"square"}],)"
        R"("materials":[{"name":"cloth","pbrMetallicRoughness":{"metallicFactor":0}}]})");
    const std::vector<float> corners{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
    json["meshes"][0]["primitives"][0] = {{"material", 0}, {"mode", 4}};
    primitive()["attributes"]["POSITION"] = add(corners, "VEC3", 5126);
    // Blender wants the bounds.
    json["accessors"][0]["min"] = {0, 0, 0};
    json["accessors"][0]["max"] = {1, 1, 0};
    set_uvs({0, 1, 1, 1, 1, 0, 0, 0});
    primitive()["indices"] = add<uint16_t>({0, 1, 2, 0, 2, 3}, "SCALAR", 5123);
  }

  nlohmann::json& primitive() { return json["meshes"][0]["primitives"][0]; }
  nlohmann::json& material() { return json["materials"][0]; }
  /// v down, as glTF has them.
  void set_uvs(const std::vector<float>& uvs) {
    primitive()["attributes"]["TEXCOORD_0"] = add(uvs, "VEC2", 5126);
  }

  size_t add_view(const std::string& bytes) {
    while (binary.size() % 4) binary += '\0';
    json["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", bytes.size()}});
    binary += bytes;
    return json["bufferViews"].size() - 1;
  }
  /// An accessor of its own; gives its index.
  template <typename T>
  size_t add(const std::vector<T>& values, const std::string& type, int component_type,
             bool normalised = false) {
    const size_t components = type == "SCALAR" ? 1
                              : type == "MAT4" ? 16
                                               : static_cast<size_t>(type.back() - '0');
    std::string bytes;
    append(bytes, values);
    json["accessors"].push_back({{"bufferView", add_view(bytes)},
                                 {"componentType", component_type},
                                 {"count", values.size() / components},
                                 {"type", type},
                                 {"normalized", normalised}});
    return json["accessors"].size() - 1;
  }
  /// A texture of an encoded picture; gives its textureInfo.
  nlohmann::json add_picture(const std::string& encoded, const nlohmann::json& sampler = nullptr) {
    json["images"].push_back({{"bufferView", add_view(encoded)}, {"mimeType", "image/png"}});
    nlohmann::json texture = {{"source", json["images"].size() - 1}};
    if (!sampler.is_null()) {
      json["samplers"].push_back(sampler);
      texture["sampler"] = json["samplers"].size() - 1;
    }
    json["textures"].push_back(texture);
    return {{"index", json["textures"].size() - 1}};
  }
  nlohmann::json& colour_info() { return material()["pbrMetallicRoughness"]["baseColorTexture"]; }

  std::string bytes() const {
    nlohmann::json whole = json;
    if (!whole.contains("buffers")) whole["buffers"] = nlohmann::json::array();
    if (whole["buffers"].empty()) whole["buffers"].push_back(nlohmann::json::object());
    whole["buffers"][0]["byteLength"] = binary.size();
    return glb_of(whole.dump(), binary);
  }
};

}  // namespace ohb
