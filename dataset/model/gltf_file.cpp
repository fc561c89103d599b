#include "dataset/model/gltf_file.h"

#include <cstring>

#include "dataset/model/atomic_file.h"
#include "dataset/model/error.h"
#include "dataset/model/json_text.h"
#include "dataset/model/scan_readers.h"

namespace ohb {
namespace {

using nlohmann::json;

constexpr const char* kExportAgain = kGltfExportAgain;
constexpr JsonLimits kJsonLimits{128, size_t{1} << 24};
constexpr const char* kTruncated = kGltfTruncated;

uint32_t little_endian(const char* bytes) {
  unsigned char b[4];
  std::memcpy(b, bytes, 4);
  return b[0] | b[1] << 8 | b[2] << 16 | static_cast<uint32_t>(b[3]) << 24;
}

/// Extensions that change nothing a scan is read for, or that are read. All of materials are of the second
/// kind or noted.
bool is_read(const std::string& extension) {
  for (const char* known :
       {"KHR_mesh_quantization", "KHR_texture_transform", "EXT_meshopt_compression", "EXT_texture_webp",
        "KHR_draco_mesh_compression", "KHR_lights_punctual", "KHR_xmp_json_ld", "KHR_animation_pointer"})
    if (extension == known) return true;
  return extension.compare(0, 14, "KHR_materials_") == 0;
}

std::string mend_for(const std::string& extension) {
  if (extension == "KHR_texture_basisu")
    return "its pictures are KTX2 files, which are not read: export it with PNG or JPEG pictures";
  if (extension == "EXT_mesh_gpu_instancing") return "export each copy as an object of its own";
  return "export it without this extension";
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

int base64_digit(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  return c == '+' ? 62 : c == '/' ? 63 : -1;
}

}  // namespace

bool GltfFile::is_fallback(const json& buffer) {
  const auto extensions = buffer.find("extensions");
  if (extensions == buffer.end() || !extensions->contains("EXT_meshopt_compression")) return false;
  return extensions->at("EXT_meshopt_compression").value("fallback", false);
}

std::string gltf_place(const char* kind, size_t index) {
  return std::string(kind) + "[" + std::to_string(index) + "]";
}

size_t index_or(const json& object, const char* key, size_t missing) {
  const auto found = object.find(key);
  if (found == object.end()) return missing;
  const double value = found->is_number() ? found->get<double>() : -1;
  if (!(value >= 0 && value <= 9007199254740992.0) ||
      value != static_cast<double>(static_cast<size_t>(value)))
    throw json::other_error::create(
        501, std::string("'") + key + "' is no index: " + found->dump().substr(0, 40), &object);
  return static_cast<size_t>(value);
}

std::string decode_percent(const std::string& uri) {
  std::string text;
  for (size_t i = 0; i < uri.size(); ++i) {
    const bool escape =
        uri[i] == '%' && i + 2 < uri.size() && hex_digit(uri[i + 1]) >= 0 && hex_digit(uri[i + 2]) >= 0;
    if (escape) {
      text += static_cast<char>(hex_digit(uri[i + 1]) * 16 + hex_digit(uri[i + 2]));
      i += 2;
    } else {
      text += uri[i];
    }
  }
  return text;
}

GltfFile::GltfFile(const std::filesystem::path& file) : file_(file) {
  const std::string content = read_file(file);
  if (content.compare(0, 4, "glTF") == 0) {
    read_container(content);
  } else if (file.extension() == ".gltf" || file.extension() == ".GLTF") {
    read_json(content);
  } else {
    fail("byte 0", "is no GLB file: it does not begin with 'glTF'", kExportAgain);
  }
  check_extensions();
  read_buffers();
}

/// First of all: a file that needs what is not read must not be called damaged for it.
void GltfFile::check_extensions() const {
  if (!root_.contains("extensionsRequired")) return;
  for (const json& name : root_.at("extensionsRequired"))
    if (!is_read(name.get<std::string>()))
      fail("extensionsRequired", "needs " + name.get<std::string>() + ", which is not read",
           mend_for(name.get<std::string>()));
}

void GltfFile::fail(const std::string& place, const std::string& cause, const std::string& mend) const {
  throw InputError(file_.string(), place, cause, mend);
}

void GltfFile::read_container(const std::string& content) {
  if (content.size() < 20)
    fail("byte " + std::to_string(content.size()), "GLB header is cut off", kTruncated);
  if (little_endian(&content[4]) != 2)
    fail("byte 4", "glTF version " + std::to_string(little_endian(&content[4])), "export it as glTF 2.0");
  const size_t length = little_endian(&content[8]);
  if (length > content.size())
    fail("byte 8", "states " + std::to_string(length) + " bytes but has " + std::to_string(content.size()),
         kTruncated);
  bool has_json = false;
  for (size_t at = 12; at + 8 <= length;) {
    const size_t size = little_endian(&content[at]);
    const uint32_t kind = little_endian(&content[at + 4]);
    if (size > length - at - 8)
      fail("byte " + std::to_string(at), "chunk of " + std::to_string(size) + " bytes goes beyond the end",
           kTruncated);
    if (kind == 0x4E4F534A && !has_json) {
      read_json(std::string_view(content).substr(at + 8, size));
      has_json = true;
    } else if (kind == 0x004E4942 && binary_chunk_.empty()) {
      binary_chunk_ = content.substr(at + 8, size);
    }
    at += 8 + size;
  }
  if (!has_json) fail("byte 12", "has no JSON chunk", kExportAgain);
}

void GltfFile::read_json(std::string_view text) {
  if (text.substr(0, 3) == "\xEF\xBB\xBF") text.remove_prefix(3);
  root_ = parse_json(text, file_.string(), kJsonLimits);
  if (!root_.is_object()) fail("JSON", "is no object", kExportAgain);
}

void GltfFile::read_buffers() {
  for (size_t i = 0; i < count("buffers"); ++i) {
    const json& buffer = item("buffers", i);
    const std::string place = gltf_place("buffers", i);
    std::string bytes;
    if (is_fallback(buffer) && !buffer.contains("uri") && (i != 0 || binary_chunk_.empty())) {
      buffers_.emplace_back();  // its buffer views are compressed
      continue;
    }
    if (!buffer.contains("uri")) {
      if (i != 0 || binary_chunk_.empty())
        fail(place, "has no data: the binary chunk is missing", kTruncated);
      bytes.swap(binary_chunk_);
    } else {
      const std::string uri = buffer.at("uri").get<std::string>();
      if (!decode_data_uri(uri, place, bytes)) bytes = read_file(file_.parent_path() / decode_percent(uri));
    }
    const size_t length = index_or(buffer, "byteLength", 0);
    if (length > bytes.size())
      fail(place, "states " + std::to_string(length) + " bytes but has " + std::to_string(bytes.size()),
           kTruncated);
    buffers_.push_back(std::move(bytes));
  }
}

size_t GltfFile::count(const char* kind) const {
  const auto found = root_.find(kind);
  if (found == root_.end()) return 0;
  if (!found->is_array()) fail(kind, "is no array", kExportAgain);
  return found->size();
}

const json& GltfFile::item(const char* kind, size_t index) const {
  const size_t available = count(kind);
  if (index >= available)
    fail(gltf_place(kind, index), "is used but the file has " + std::to_string(available), kExportAgain);
  const json& found = root_[kind][index];
  if (!found.is_object()) fail(gltf_place(kind, index), "is no object", kExportAgain);
  return found;
}

bool GltfFile::decode_data_uri(const std::string& uri, const std::string& place, std::string& bytes) const {
  if (uri.compare(0, 5, "data:") != 0) return false;
  const size_t comma = uri.find(',');
  if (comma == std::string::npos || uri.rfind(";base64", comma) == std::string::npos)
    fail(place, "has a data URI that is not base64", kExportAgain);
  uint32_t bits = 0;
  int bit_count = 0;
  for (size_t i = comma + 1; i < uri.size() && uri[i] != '='; ++i) {
    const int digit = base64_digit(uri[i]);
    if (digit < 0) fail(place, "has a data URI that is not base64", kExportAgain);
    bits = (bits << 6 | static_cast<uint32_t>(digit)) & 0xffffff;
    bit_count += 6;
    if (bit_count >= 8) {
      bit_count -= 8;
      bytes += static_cast<char>(bits >> bit_count & 0xff);
    }
  }
  return true;
}

}  // namespace ohb
