#include "dataset/model/gltf_file.h"

#include <cstring>

#include "dataset/model/atomic_file.h"
#include "dataset/model/error.h"
#include "dataset/model/scan_readers.h"

namespace ohb {
namespace {

using nlohmann::json;

constexpr const char* kExportAgain = "export the scan again";
constexpr const char* kTruncated = "the file is truncated: copy or export it again";

uint32_t little_endian(const char* bytes) {
  unsigned char b[4];
  std::memcpy(b, bytes, 4);
  return b[0] | b[1] << 8 | b[2] << 16 | static_cast<uint32_t>(b[3]) << 24;
}

std::string place_of(const char* kind, size_t index) {
  return std::string(kind) + "[" + std::to_string(index) + "]";
}

size_t size_of_component(int type) {
  switch (type) {
    case 5120:
    case 5121:
      return 1;
    case 5122:
    case 5123:
      return 2;
    case 5125:
    case 5126:
      return 4;
    default:
      return 0;
  }
}

template <typename T>
T load(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

float load_float(const char* bytes, int type, bool normalised) {
  switch (type) {
    case 5120:
      return normalised ? std::max(load<int8_t>(bytes) / 127.0f, -1.0f) : load<int8_t>(bytes);
    case 5121:
      return normalised ? load<uint8_t>(bytes) / 255.0f : load<uint8_t>(bytes);
    case 5122:
      return normalised ? std::max(load<int16_t>(bytes) / 32767.0f, -1.0f) : load<int16_t>(bytes);
    case 5123:
      return normalised ? load<uint16_t>(bytes) / 65535.0f : load<uint16_t>(bytes);
    case 5125:
      return static_cast<float>(load<uint32_t>(bytes));
    default:
      return load<float>(bytes);
  }
}

size_t components_of(const std::string& type) {
  if (type == "SCALAR") return 1;
  if (type == "VEC2") return 2;
  if (type == "VEC3") return 3;
  if (type == "VEC4") return 4;
  return 0;
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

struct GltfFile::Accessor {
  const char* data = nullptr;  // null: all zeros
  size_t count = 0, stride = 0;
  int type = 0;
  bool normalised = false;
};

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
  read_buffers();
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
  try {
    root_ = json::parse(text.begin(), text.end());
  } catch (const json::parse_error& error) {
    fail("JSON", "byte " + std::to_string(error.byte) + " cannot be parsed", kExportAgain);
  }
  if (!root_.is_object()) fail("JSON", "is no object", kExportAgain);
}

void GltfFile::read_buffers() {
  for (size_t i = 0; i < count("buffers"); ++i) {
    const json& buffer = item("buffers", i);
    const std::string place = place_of("buffers", i);
    std::string bytes;
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
    fail(place_of(kind, index), "is used but the file has " + std::to_string(available), kExportAgain);
  const json& found = root_[kind][index];
  if (!found.is_object()) fail(place_of(kind, index), "is no object", kExportAgain);
  return found;
}

std::string_view GltfFile::buffer_view(size_t view) const {
  const json& object = item("bufferViews", view);
  const size_t buffer = index_or(object, "buffer");
  if (buffer >= buffers_.size())
    fail(place_of("bufferViews", view), "names no buffer of the file", kExportAgain);
  const size_t offset = index_or(object, "byteOffset", 0), length = index_or(object, "byteLength", 0);
  const std::string& bytes = buffers_[buffer];
  if (offset > bytes.size() || length > bytes.size() - offset)
    fail(place_of("bufferViews", view),
         "goes beyond its buffer of " + std::to_string(bytes.size()) + " bytes", kTruncated);
  return std::string_view(bytes).substr(offset, length);
}

GltfFile::Accessor GltfFile::accessor(size_t index, size_t components) const {
  const json& object = item("accessors", index);
  const std::string place = place_of("accessors", index);
  if (object.contains("sparse"))
    fail(place, "is sparse, which is not supported", "export without sparse data");
  Accessor result;
  result.type = static_cast<int>(std::min<size_t>(index_or(object, "componentType", 0), 100000));
  result.count = index_or(object, "count", 0);
  result.normalised = object.value("normalized", false);
  const size_t component_bytes = size_of_component(result.type);
  if (component_bytes == 0)
    fail(place, "has the unknown component type " + std::to_string(result.type), kExportAgain);
  if (components_of(object.value("type", "")) != components)
    fail(place, "has the type '" + object.value("type", "") + "'", kExportAgain);
  if (result.count > kMaxScanElements)
    fail(place, "has " + std::to_string(result.count) + " elements",
         "a scan may have " + std::to_string(kMaxScanElements));
  const size_t element_bytes = components * component_bytes;
  result.stride = element_bytes;
  const size_t view_index = index_or(object, "bufferView");
  if (view_index == kMissing) return result;
  const std::string_view bytes = buffer_view(view_index);
  const size_t offset = index_or(object, "byteOffset", 0);
  result.stride = index_or(item("bufferViews", view_index), "byteStride", element_bytes);
  const bool sane = result.stride >= element_bytes && result.stride <= 255 && offset <= bytes.size();
  if (!sane ||
      (result.count > 0 && (result.count - 1) * result.stride + element_bytes > bytes.size() - offset))
    fail(place,
         "with " + std::to_string(result.count) + " elements goes beyond its buffer view of " +
             std::to_string(bytes.size()) + " bytes",
         kTruncated);
  result.data = bytes.data() + offset;
  return result;
}

std::vector<float> GltfFile::floats(size_t index, size_t components) const {
  const Accessor from = accessor(index, components);
  std::vector<float> values(from.count * components, 0.0f);
  if (!from.data) return values;
  const size_t component_bytes = size_of_component(from.type);
  for (size_t i = 0; i < from.count; ++i)
    for (size_t c = 0; c < components; ++c)
      values[i * components + c] =
          load_float(from.data + i * from.stride + c * component_bytes, from.type, from.normalised);
  return values;
}

std::vector<uint32_t> GltfFile::indices(size_t index) const {
  const Accessor from = accessor(index, 1);
  std::vector<uint32_t> values(from.count, 0);
  if (!from.data) return values;
  for (size_t i = 0; i < from.count; ++i) {
    const char* at = from.data + i * from.stride;
    switch (from.type) {
      case 5121:
        values[i] = load<uint8_t>(at);
        break;
      case 5123:
        values[i] = load<uint16_t>(at);
        break;
      case 5125:
        values[i] = load<uint32_t>(at);
        break;
      default:
        fail(place_of("accessors", index), "holds no unsigned integers", kExportAgain);
    }
  }
  return values;
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
