// Small scans as texts and bytes, for tests.
#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "dataset/model/image.h"
#include "dataset/model/vec.h"

namespace ohb {

/// Writes the bytes (folders on the way are made) and gives the path back.
inline std::filesystem::path write_bytes(const std::filesystem::path& file, const std::string& bytes) {
  std::filesystem::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  return file;
}

/// A square with UVs, of one quad.
inline const char* const kQuadObj =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
    "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
    "f 1/1 2/2 3/3 4/4\n";

/// A small PNG of distinct values.
inline void write_small_png(const std::filesystem::path& file, int channels = 3, int size_px = 8) {
  Image image(size_px, size_px, channels);
  for (size_t i = 0; i < image.values.size(); ++i) image.values[i] = static_cast<float>(i % 256) / 255;
  write_png(file, image);
}

template <typename T>
void append(std::string& bytes, const std::vector<T>& values) {
  if (values.empty()) return;
  const size_t at = bytes.size();
  bytes.resize(at + values.size() * sizeof(T));
  std::memcpy(&bytes[at], values.data(), values.size() * sizeof(T));
}

/// A GLB container: JSON and, if not empty, the binary chunk.
inline std::string glb_of(std::string json, std::string binary) {
  while (json.size() % 4) json += ' ';
  while (binary.size() % 4) binary += '\0';
  const auto size = [](size_t n) { return static_cast<uint32_t>(n); };
  const size_t total = 12 + 8 + json.size() + (binary.empty() ? 0 : 8 + binary.size());
  std::string bytes = "glTF";
  append<uint32_t>(bytes, {2, size(total), size(json.size()), 0x4E4F534A});
  bytes += json;
  if (!binary.empty()) {
    append<uint32_t>(bytes, {size(binary.size()), 0x004E4942});
    bytes += binary;
  }
  return bytes;
}

/// The two triangles of kQuadObj as a GLB's JSON and binary chunk: positions at 0, UVs (v down) at 48,
/// 16-bit indices at 80, then `picture` (an encoded PNG or JPEG) if there is one.
inline std::string quad_glb_binary(const std::string& picture = "") {
  std::string binary;
  append<float>(binary, {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0});
  append<float>(binary, {0, 1, 1, 1, 1, 0, 0, 0});
  append<uint16_t>(binary, {0, 1, 2, 0, 2, 3});
  return binary + picture;
}
inline std::string quad_glb_json(size_t picture_bytes = 0) {
  const std::string picture_view =
      R"(,{"buffer":0,"byteOffset":92,"byteLength":)" + std::to_string(picture_bytes) + "}";
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],)"
         R"("nodes":[{"name":"square","mesh":0}],)"
         R"("meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"indices":2)" +
         std::string(picture_bytes ? R"(,"material":0)" : "") + R"(}]}],)" +
         (picture_bytes ? R"("materials":[{"name":"cloth","alphaMode":"MASK","pbrMetallicRoughness":)"
                          R"({"baseColorTexture":{"index":0}}}],"textures":[{"source":0}],)"
                          R"("images":[{"bufferView":3,"mimeType":"image/png"}],)"
                        : "") +
         R"("accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"},)"
         R"({"bufferView":1,"componentType":5126,"count":4,"type":"VEC2"},)"
         R"({"bufferView":2,"componentType":5123,"count":6,"type":"SCALAR"}],)"
         R"("bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":48},)"
         R"({"buffer":0,"byteOffset":48,"byteLength":32},{"buffer":0,"byteOffset":80,"byteLength":12})" +
         (picture_bytes ? picture_view : "") + R"(],"buffers":[{"byteLength":)" +
         std::to_string(92 + picture_bytes) + "}]}";
}

}  // namespace ohb
