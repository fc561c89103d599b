// The container of glTF 2.0: JSON, buffers and accessors, every offset and count checked. What the numbers
// mean (nodes, materials) is scan_gltf.cpp's matter.
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace ohb {

/// All functions throw InputError with the place in the JSON ("accessors[3]").
class GltfFile {
 public:
  /// Reads .glb or .gltf with its buffers (binary chunk, data: URIs, files beside it). Refuses extensions
  /// that the file requires and that are not read before anything else.
  explicit GltfFile(const std::filesystem::path& file);

  const nlohmann::json& root() const { return root_; }
  const std::filesystem::path& path() const { return file_; }

  /// Element `index` of the top-level array `kind` ("nodes", "meshes", ...).
  const nlohmann::json& item(const char* kind, size_t index) const;
  size_t count(const char* kind) const;

  /// Numbers an element of the accessor has: 1 to 4, 16 of a 4 x 4 matrix.
  size_t components(size_t accessor) const;
  /// The accessor's numbers, `components` an element; normalised integers become fractions, sparse elements
  /// take the place of others.
  std::vector<float> floats(size_t accessor, size_t components) const;
  /// The accessor's unsigned integers.
  std::vector<uint32_t> indices(size_t accessor) const;
  /// The bytes of a buffer view, decompressed where EXT_meshopt_compression says so.
  std::string_view buffer_view(size_t view) const;

  /// Bytes of a "data:...;base64," URI. False if `uri` is none.
  bool decode_data_uri(const std::string& uri, const std::string& place, std::string& bytes) const;

  [[noreturn]] void fail(const std::string& place, const std::string& cause, const std::string& mend) const;

 private:
  struct Accessor;
  struct Sparse;

  void read_container(const std::string& content);
  void read_json(std::string_view text);
  void read_buffers();
  void check_extensions() const;
  static bool is_fallback(const nlohmann::json& buffer);
  Accessor accessor(size_t index, size_t components) const;
  Accessor packed(const nlohmann::json& from, Accessor shape, const std::string& place) const;
  Sparse sparse(size_t index, const Accessor& whole) const;
  std::string_view stored_view(const nlohmann::json& view, const std::string& place) const;
  std::string decompressed(const nlohmann::json& compression, const std::string& place) const;

  std::filesystem::path file_;
  nlohmann::json root_;
  std::string binary_chunk_;
  std::vector<std::string> buffers_;
  mutable std::map<size_t, std::string> decompressed_;  // buffer views
};

constexpr const char* kGltfExportAgain = "export the scan again";
constexpr const char* kGltfTruncated = "the file is truncated: copy or export it again";
/// "accessors[3]"
std::string gltf_place(const char* kind, size_t index);

/// `object[key]` as an index (0 to 2^31); `missing` if the key is not there.
constexpr size_t kMissing = static_cast<size_t>(-1);
size_t index_or(const nlohmann::json& object, const char* key, size_t missing = kMissing);

/// A URI's percent escapes decoded.
std::string decode_percent(const std::string& uri);

}  // namespace ohb
