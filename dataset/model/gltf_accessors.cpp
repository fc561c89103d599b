// The numbers of a glTF file: buffer views and accessors.
#include <cstring>

#include "dataset/model/error.h"
#include "dataset/model/gltf_file.h"
#include "dataset/model/scan_readers.h"

namespace ohb {
namespace {

using nlohmann::json;

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
  if (type == "MAT4") return 16;
  return 0;
}

uint32_t load_index(const char* bytes, int type) {
  switch (type) {
    case 5121:
      return load<uint8_t>(bytes);
    case 5123:
      return load<uint16_t>(bytes);
    default:
      return load<uint32_t>(bytes);
  }
}

bool is_index_type(int type) {
  return type == 5121 || type == 5123 || type == 5125;
}

}  // namespace

struct GltfFile::Accessor {
  const char* data = nullptr;  // null: all zeros
  size_t count = 0, stride = 0, element_bytes = 0;
  int type = 0;
  bool normalised = false;
};

/// Elements that take the place of others.
struct GltfFile::Sparse {
  std::vector<uint32_t> places;
  Accessor values;
};

std::string_view GltfFile::stored_view(const json& view, const std::string& place) const {
  const size_t buffer = index_or(view, "buffer");
  if (buffer >= buffers_.size()) fail(place, "names no buffer of the file", kGltfExportAgain);
  const size_t offset = index_or(view, "byteOffset", 0), length = index_or(view, "byteLength", 0);
  const std::string& bytes = buffers_[buffer];
  if (offset > bytes.size() || length > bytes.size() - offset) {
    const bool is_absent = bytes.empty() && is_fallback(item("buffers", buffer));
    fail(place,
         is_absent ? std::string("lies in a buffer for EXT_meshopt_compression but is not compressed")
                   : "goes beyond its buffer of " + std::to_string(bytes.size()) + " bytes",
         is_absent ? kGltfExportAgain : kGltfTruncated);
  }
  return std::string_view(bytes).substr(offset, length);
}

std::string_view GltfFile::buffer_view(size_t view) const {
  const json& object = item("bufferViews", view);
  const std::string place = gltf_place("bufferViews", view);
  const auto extensions = object.find("extensions");
  if (extensions == object.end() || !extensions->contains("EXT_meshopt_compression"))
    return stored_view(object, place);
  const auto known = decompressed_.find(view);
  if (known != decompressed_.end()) return known->second;
  try {
    return decompressed_[view] = decompressed(extensions->at("EXT_meshopt_compression"), place);
  } catch (const InputError&) {
    const size_t buffer = index_or(object, "buffer");
    if (buffer >= buffers_.size() || buffers_[buffer].empty()) throw;
    return stored_view(object, place);  // the same, not compressed, for programs without the extension
  }
}

size_t GltfFile::components(size_t accessor) const {
  return components_of(item("accessors", accessor).value("type", ""));
}

/// Where `from` (an accessor, or a part of a sparse one) has its bytes; `shape` says of which elements.
GltfFile::Accessor GltfFile::packed(const json& from, Accessor shape, const std::string& place) const {
  shape.stride = shape.element_bytes;
  const size_t view_index = index_or(from, "bufferView");
  if (view_index == kMissing) return shape;
  const std::string_view bytes = buffer_view(view_index);
  const size_t offset = index_or(from, "byteOffset", 0);
  shape.stride = index_or(item("bufferViews", view_index), "byteStride", shape.element_bytes);
  const bool sane = shape.stride >= shape.element_bytes && shape.stride <= 255 && offset <= bytes.size();
  if (!sane ||
      (shape.count > 0 && (shape.count - 1) * shape.stride + shape.element_bytes > bytes.size() - offset))
    fail(place,
         "with " + std::to_string(shape.count) + " elements goes beyond its buffer view of " +
             std::to_string(bytes.size()) + " bytes",
         kGltfTruncated);
  shape.data = bytes.data() + offset;
  return shape;
}

GltfFile::Accessor GltfFile::accessor(size_t index, size_t components) const {
  const json& object = item("accessors", index);
  const std::string place = gltf_place("accessors", index);
  Accessor shape;
  shape.type = static_cast<int>(std::min<size_t>(index_or(object, "componentType", 0), 100000));
  shape.count = index_or(object, "count", 0);
  shape.normalised = object.value("normalized", false);
  const size_t component_bytes = size_of_component(shape.type);
  if (component_bytes == 0)
    fail(place, "has the unknown component type " + std::to_string(shape.type), kGltfExportAgain);
  if (components_of(object.value("type", "")) != components)
    fail(place, "has the type '" + object.value("type", "") + "'", kGltfExportAgain);
  if (shape.count > kMaxScanElements)
    fail(place, "has " + std::to_string(shape.count) + " elements",
         "a scan may have " + std::to_string(kMaxScanElements));
  shape.element_bytes = components * component_bytes;
  return packed(object, shape, place);
}

GltfFile::Sparse GltfFile::sparse(size_t index, const Accessor& whole) const {
  Sparse sparse;
  const json& object = item("accessors", index);
  if (!object.contains("sparse")) return sparse;
  const json& from = object.at("sparse");
  const std::string place = gltf_place("accessors", index) + ".sparse";
  Accessor places;
  places.count = index_or(from, "count", 0);
  places.type = static_cast<int>(std::min<size_t>(index_or(from.at("indices"), "componentType", 0), 100000));
  places.element_bytes = size_of_component(places.type);
  if (!is_index_type(places.type) || places.count > whole.count)
    fail(place, "has other elements than its accessor", kGltfExportAgain);
  places = packed(from.at("indices"), places, place);
  sparse.values = whole;
  sparse.values.count = places.count;
  sparse.values = packed(from.at("values"), sparse.values, place);
  if (places.count > 0 && (!places.data || index_or(from.at("values"), "bufferView") == kMissing))
    fail(place, "has no data", kGltfExportAgain);
  for (size_t i = 0; i < places.count; ++i) {
    sparse.places.push_back(load_index(places.data + i * places.stride, places.type));
    if (sparse.places.back() >= whole.count)
      fail(place,
           "replaces element " + std::to_string(sparse.places.back()) + " of " + std::to_string(whole.count),
           kGltfExportAgain);
  }
  return sparse;
}

std::vector<float> GltfFile::floats(size_t index, size_t components) const {
  const Accessor from = accessor(index, components);
  const size_t component_bytes = size_of_component(from.type);
  std::vector<float> values(from.count * components, 0.0f);
  const auto copy = [&](const Accessor& source, size_t element, size_t to) {
    for (size_t c = 0; c < components; ++c)
      values[to * components + c] = load_float(source.data + element * source.stride + c * component_bytes,
                                               source.type, source.normalised);
  };
  if (from.data)
    for (size_t i = 0; i < from.count; ++i) copy(from, i, i);
  const Sparse others = sparse(index, from);
  for (size_t i = 0; i < others.places.size(); ++i) copy(others.values, i, others.places[i]);
  return values;
}

std::vector<uint32_t> GltfFile::indices(size_t index) const {
  const Accessor from = accessor(index, 1);
  if (!is_index_type(from.type))
    fail(gltf_place("accessors", index), "holds no unsigned integers", kGltfExportAgain);
  std::vector<uint32_t> values(from.count, 0);
  if (from.data)
    for (size_t i = 0; i < from.count; ++i) values[i] = load_index(from.data + i * from.stride, from.type);
  const Sparse others = sparse(index, from);
  for (size_t i = 0; i < others.places.size(); ++i)
    values[others.places[i]] = load_index(others.values.data + i * others.values.stride, from.type);
  return values;
}

}  // namespace ohb
