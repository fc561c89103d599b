#include "dataset/model/fbx_file.h"

#include <openssl/evp.h>
#include <zlib.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>

#include "dataset/model/atomic_file.h"
#include "dataset/model/error.h"
#include "dataset/model/scan_readers.h"
#include "dataset/model/text_lines.h"

namespace ohb {
namespace {

constexpr const char* kExportAgain = "export the scan again";
constexpr std::string_view kBinaryMagic("Kaydara FBX Binary  \0", 21);

template <typename T>
T load(std::string_view bytes, size_t index) {
  T value;
  std::memcpy(&value, bytes.data() + index * sizeof(T), sizeof(T));
  return value;
}

/// Bytes of one value in a list ('#'); 0 for texts and arrays, which lists of numbers do not hold.
size_t value_bytes(char type) {
  switch (type) {
    case 'C':
      return 1;
    case 'Y':
      return 2;
    case 'I':
    case 'F':
      return 4;
    case 'L':
    case 'D':
      return 8;
    default:
      return 0;
  }
}

double load_value(char type, std::string_view bytes) {
  switch (type) {
    case 'C':
      return load<uint8_t>(bytes, 0);
    case 'Y':
      return load<int16_t>(bytes, 0);
    case 'I':
      return load<int32_t>(bytes, 0);
    case 'L':
      return static_cast<double>(load<int64_t>(bytes, 0));
    case 'F':
      return load<float>(bytes, 0);
    default:
      return load<double>(bytes, 0);
  }
}

size_t element_bytes(char type) {
  switch (type) {
    case 'b':
      return 1;
    case 'i':
    case 'f':
      return 4;
    case 'l':
    case 'd':
      return 8;
    default:
      return 0;
  }
}

double load_element(std::string_view bytes, char type, size_t index) {
  switch (type) {
    case 'b':
      return load<uint8_t>(bytes, index);
    case 'i':
      return load<int32_t>(bytes, index);
    case 'f':
      return load<float>(bytes, index);
    case 'l':
      return static_cast<double>(load<int64_t>(bytes, index));
    default:
      return load<double>(bytes, index);
  }
}

std::string inflated(std::string_view packed, size_t size) {
  std::string bytes(size, '\0');
  uLongf length = static_cast<uLongf>(size);
  const int state =
      uncompress(reinterpret_cast<Bytef*>(bytes.data()), &length,
                 reinterpret_cast<const Bytef*>(packed.data()), static_cast<uLong>(packed.size()));
  if (state != Z_OK || length != size) return std::string();
  return bytes;
}

/// Calls `take(word)` for each number of "1,2, 3".
template <typename Take>
void split_numbers(std::string_view text, const Take& take) {
  size_t at = 0;
  const auto separates = [](char c) { return c == ',' || c == ' ' || c == '\t' || c == '\r' || c == '\n'; };
  while (at < text.size()) {
    while (at < text.size() && separates(text[at])) ++at;
    const size_t begin = at;
    while (at < text.size() && !separates(text[at])) ++at;
    if (at > begin) take(text.substr(begin, at - begin));
  }
}

}  // namespace

const FbxNode* FbxNode::child(std::string_view child_name) const {
  for (const FbxNode& node : children)
    if (node.name == child_name) return &node;
  return nullptr;
}

FbxFile::FbxFile(const std::filesystem::path& file) : file_(file), content_(read_file(file)) {
  tree_ = is_binary() ? parse_binary_fbx(file_, content_) : parse_ascii_fbx(file_, content_);
}

bool FbxFile::is_binary() const {
  return std::string_view(content_).substr(0, kBinaryMagic.size()) == kBinaryMagic;
}

std::string FbxFile::embedded_bytes(const FbxNode& content) const {
  if (content.values.empty()) return "";
  if (is_binary()) return text(content, 0);
  std::string base64;  // pieces, with quotes and commas between them in long lists
  for (const FbxValue& value : content.values)
    for (char c : value.bytes)
      if (std::isalnum(static_cast<unsigned char>(c)) || c == '+' || c == '/' || c == '=') base64 += c;
  if (base64.empty()) return "";
  std::string bytes(base64.size() / 4 * 3 + 3, '\0');
  const int size =
      EVP_DecodeBlock(reinterpret_cast<unsigned char*>(bytes.data()),
                      reinterpret_cast<const unsigned char*>(base64.data()), static_cast<int>(base64.size()));
  if (size < 0) fail("Content", "is no base64", kExportAgain);
  const size_t padding = base64.size() - base64.find_last_not_of('=') - 1;
  bytes.resize(static_cast<size_t>(size) - std::min<size_t>(padding, 2));
  return bytes;
}

void FbxFile::fail(const std::string& place, const std::string& cause, const std::string& mend) const {
  throw InputError(file_.string(), place, cause, mend);
}

std::string FbxFile::text(const FbxNode& node, size_t index) const {
  const bool there = index < node.values.size();
  if (!there ||
      (node.values[index].type != 'S' && node.values[index].type != 'R' && node.values[index].type != 'T'))
    fail(std::string(node.name), "value " + std::to_string(index + 1) + " is no text", kExportAgain);
  return std::string(node.values[index].bytes);
}

double FbxFile::number(const FbxNode& node, size_t index) const {
  double parsed = 0;
  if (index < node.values.size()) {
    const FbxValue& value = node.values[index];
    if (value_bytes(value.type) > 0) return load_value(value.type, value.bytes);
    if (value.type == 'T' && parse_double(value.bytes, parsed)) return parsed;
  }
  fail(std::string(node.name), "value " + std::to_string(index + 1) + " is no number", kExportAgain);
}

int64_t FbxFile::integer(const FbxNode& node, size_t index) const {
  if (index < node.values.size()) {
    const FbxValue& value = node.values[index];
    if (value.type == 'L') return load<int64_t>(value.bytes, 0);  // beyond the precision of double
    long long parsed = 0;
    if (value.type == 'T' && parse_integer(value.bytes, parsed)) return parsed;
  }
  const double value = number(node, index);
  if (!(std::abs(value) < 9e15)) fail(std::string(node.name), "has no integer", kExportAgain);
  return static_cast<int64_t>(value);
}

void FbxFile::check_room(const FbxNode& node, size_t count) const {
  if (count > 3 * kMaxScanElements)
    fail(std::string(node.name), "has " + std::to_string(count) + " numbers", "reduce the scan");
}

std::vector<double> FbxFile::numbers(const FbxNode& node) const {
  if (node.values.empty()) {
    if (version() < 7000) return {};
    fail(std::string(node.name), "is no array", kExportAgain);
  }
  const FbxValue& value = node.values[0];
  if (value.type == '*') return text_numbers(node, value);
  if (value.type == '#') return listed_numbers(node, value);
  if (element_bytes(value.type) > 0) return array_numbers(node, value);
  std::vector<double> result;  // a short list of version 6
  for (size_t i = 0; i < node.values.size(); ++i) result.push_back(number(node, i));
  return result;
}

std::vector<double> FbxFile::text_numbers(const FbxNode& node, const FbxValue& value) const {
  std::vector<double> result;
  split_numbers(value.bytes, [&](std::string_view word) {
    double parsed = 0;
    if (!parse_double(word, parsed))
      fail(std::string(node.name), "'" + std::string(word.substr(0, 40)) + "' is no number", kExportAgain);
    result.push_back(parsed);
    check_room(node, result.size());
  });
  return result;
}

std::vector<double> FbxFile::listed_numbers(const FbxNode& node, const FbxValue& value) const {
  check_room(node, value.count);
  std::vector<double> result;
  std::string_view rest = value.bytes;
  while (!rest.empty()) {
    const char type = rest[0];
    const size_t size = value_bytes(type);
    if (size == 0 || rest.size() < 1 + size)
      fail(std::string(node.name), "holds something else than numbers", kExportAgain);
    result.push_back(load_value(type, rest.substr(1, size)));
    rest.remove_prefix(1 + size);
  }
  return result;
}

std::vector<double> FbxFile::array_numbers(const FbxNode& node, const FbxValue& value) const {
  const std::string place(node.name);
  const size_t size = element_bytes(value.type);
  check_room(node, value.count);
  std::string unpacked;
  std::string_view bytes = value.bytes;
  if (value.packed) {
    if (value.count * size / 1100 > bytes.size())
      fail(place, "states more numbers than it holds", kExportAgain);
    unpacked = inflated(bytes, value.count * size);
    bytes = unpacked;
  }
  if (bytes.size() != value.count * size) fail(place, "is damaged: it cannot be unpacked", kExportAgain);
  std::vector<double> result(value.count);
  for (size_t i = 0; i < result.size(); ++i) result[i] = load_element(bytes, value.type, i);
  return result;
}

}  // namespace ohb
