#include "learner/safetensors.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "dataset/model/atomic_file.h"
#include "dataset/model/error.h"
#include "dataset/model/foreign_content.h"
#include "dataset/model/json_text.h"

namespace ohb::learner {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;
using torch::Tensor;

constexpr uint64_t kMaxHeaderBytes = 100'000'000;
constexpr size_t kMaxDimensions = 8;
constexpr const char* kMetadata = "__metadata__";

struct TypeName {
  const char* name;
  torch::ScalarType type;
};
constexpr TypeName kTypes[] = {{"F32", torch::kFloat}, {"F16", torch::kHalf}, {"I64", torch::kLong}};

[[noreturn]] void refuse(const fs::path& file, const std::string& place, const std::string& cause) {
  throw InputError(file.string(), place, cause, "it is damaged or no file of this program: copy it again");
}

std::string header_of(const TensorFile& content) {
  json header = json::object();
  if (!content.metadata.empty()) header[kMetadata] = content.metadata;
  uint64_t at = 0;
  for (const auto& [name, tensor] : content.tensors) {
    const auto type = std::find_if(std::begin(kTypes), std::end(kTypes),
                                   [&](const TypeName& t) { return t.type == tensor.scalar_type(); });
    if (type == std::end(kTypes)) throw std::logic_error("write_tensors: type of " + name);
    header[name] = {
        {"dtype", type->name}, {"shape", tensor.sizes().vec()}, {"data_offsets", {at, at + tensor.nbytes()}}};
    at += tensor.nbytes();
  }
  std::string text = json_text(header);
  text.resize((text.size() + 7) / 8 * 8, ' ');  // so that the numbers are aligned
  return text;
}

struct Entry {
  std::string name;
  torch::ScalarType type;
  std::vector<int64_t> shape;
  uint64_t begin, end;
};

Entry entry_of(const std::string& name, const json& value, uint64_t data_bytes, const fs::path& file) {
  const std::string place = "tensor '" + name + "'";
  if (!value.is_object() || !value.contains("dtype") || !value.contains("shape") ||
      !value.contains("data_offsets") || !value["dtype"].is_string() || !value["shape"].is_array() ||
      !value["data_offsets"].is_array() || value["data_offsets"].size() != 2)
    refuse(file, place, "has no dtype, shape and data_offsets");
  Entry entry{name, torch::kFloat, {}, 0, 0};
  const std::string dtype = value["dtype"];
  const auto type =
      std::find_if(std::begin(kTypes), std::end(kTypes), [&](const TypeName& t) { return dtype == t.name; });
  if (type == std::end(kTypes)) refuse(file, place, "has the type " + dtype + ", not F32, F16 or I64");
  entry.type = type->type;
  if (value["shape"].size() > kMaxDimensions) refuse(file, place, "has too many dimensions");
  uint64_t bytes = torch::elementSize(entry.type);
  for (const json& extent : value["shape"]) {
    if (!extent.is_number_unsigned()) refuse(file, place, "has a shape that is not of whole numbers");
    const uint64_t n = extent.get<uint64_t>();
    if (n > data_bytes || (n > 0 && bytes > data_bytes / n))
      refuse(file, place, "has a shape larger than the file");
    bytes *= n;
    entry.shape.push_back(static_cast<int64_t>(n));
  }
  for (const json& offset : value["data_offsets"])
    if (!offset.is_number_unsigned()) refuse(file, place, "has a byte range that is not of whole numbers");
  entry.begin = value["data_offsets"][0];
  entry.end = value["data_offsets"][1];
  if (entry.begin > entry.end || entry.end > data_bytes || entry.end - entry.begin != bytes)
    refuse(file, place, "has a byte range that does not fit the file or its shape");
  return entry;
}

json parsed_header(const std::string& bytes, const fs::path& file) {
  refuse_foreign_content(file, std::string_view(bytes).substr(0, 512));
  uint64_t length = 0;
  if (bytes.size() < sizeof length)
    refuse(file, "", "is too short for a checkpoint (" + std::to_string(bytes.size()) + " bytes)");
  std::memcpy(&length, bytes.data(), sizeof length);
  if (length > kMaxHeaderBytes || length > bytes.size() - sizeof length)
    refuse(file, "header",
           "claims " + std::to_string(length) + " bytes, the file has " + std::to_string(bytes.size()));
  const char* begin = bytes.data() + sizeof length;
  const json header = parse_json(std::string_view(begin, length), file.string() + ": header", {4});
  if (!header.is_object()) refuse(file, "header", "is not the JSON of a safetensors file");
  return header;
}

}  // namespace

void write_tensors(const fs::path& file, const TensorFile& content) {
  const std::string header = header_of(content);
  const uint64_t length = header.size();
  std::string bytes(reinterpret_cast<const char*>(&length), sizeof length);
  bytes += header;
  for (const auto& [name, tensor] : content.tensors) {
    const Tensor packed = tensor.detach().to(torch::kCPU).contiguous();
    bytes.append(static_cast<const char*>(packed.data_ptr()), packed.nbytes());
  }
  write_file_atomically(file, bytes);
}

TensorFile read_tensors(const fs::path& file) {
  const std::string bytes = read_file(file);
  const json header = parsed_header(bytes, file);
  uint64_t header_bytes = 0;
  std::memcpy(&header_bytes, bytes.data(), sizeof header_bytes);
  const char* data = bytes.data() + sizeof header_bytes + header_bytes;
  const uint64_t data_bytes = bytes.size() - sizeof header_bytes - header_bytes;
  TensorFile content;
  std::vector<Entry> entries;
  for (const auto& [name, value] : header.items()) {
    if (name == kMetadata) {
      if (!value.is_object()) refuse(file, kMetadata, "is not an object of strings");
      for (const auto& [key, text] : value.items()) {
        if (!text.is_string()) refuse(file, kMetadata, "is not an object of strings");
        content.metadata[key] = text;
      }
    } else {
      entries.push_back(entry_of(name, value, data_bytes, file));
    }
  }
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return std::pair(a.begin, a.end) < std::pair(b.begin, b.end);
  });
  uint64_t at = 0;
  for (const Entry& entry : entries) {
    if (entry.begin != at)
      refuse(file, "tensor '" + entry.name + "'", "overlaps another or leaves a gap before it");
    at = entry.end;
    Tensor tensor = torch::empty(entry.shape, entry.type);
    if (at > entry.begin) std::memcpy(tensor.data_ptr(), data + entry.begin, at - entry.begin);
    content.tensors.emplace_back(entry.name, tensor);
  }
  if (at != data_bytes)
    refuse(file, "", "has " + std::to_string(data_bytes - at) + " bytes that belong to no tensor");
  return content;
}

}  // namespace ohb::learner
