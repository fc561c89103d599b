// The binary and the ASCII encoding of FBX 6 and 7 into one tree.
#include <cstring>

#include "dataset/model/error.h"
#include "dataset/model/fbx_file.h"
#include "dataset/model/text_lines.h"

namespace ohb {
namespace {

constexpr int kOldest = 6000, kNewest = 7900;

void check_version(const std::filesystem::path& file, const std::string& place, int64_t version) {
  if (version < kOldest || version > kNewest)
    throw InputError(
        file.string(), place, "is FBX version " + std::to_string(version),
        "versions 6 and 7 are read: export the scan from where it was made as FBX 7.4 (2014), OBJ "
        "or glTF");
}

constexpr const char* kTruncated = "the file is truncated or damaged: copy or export it again";

class BinaryParser {
 public:
  BinaryParser(const std::filesystem::path& file, std::string_view content)
      : file_(file), content_(content) {}

  FbxTree parse() {
    at_ = 23;
    if (content_[22] == 1)
      throw InputError(file_.string(), "byte 22", "is big-endian FBX",
                       "export it as FBX 7.4 (2014), OBJ or glTF");
    const auto version = take<uint32_t>();
    check_version(file_, "byte 23", version);
    wide_ = version >= 7500;
    FbxTree tree;
    tree.version = static_cast<int>(version);
    while (at_ < content_.size()) {
      FbxNode node;
      if (!parse_node(node, content_.size(), 0)) return tree;
      tree.root.children.push_back(std::move(node));
    }
    fail("ends before its last node", kTruncated);
  }

 private:
  [[noreturn]] void fail(const std::string& cause, const std::string& mend) const {
    throw InputError(file_.string(), "byte " + std::to_string(at_), cause, mend);
  }

  std::string_view take_bytes(uint64_t size) {
    if (size > content_.size() - at_)
      fail("needs " + std::to_string(size) + " more bytes than " + std::to_string(content_.size() - at_),
           kTruncated);
    const std::string_view bytes = content_.substr(at_, size);
    at_ += size;
    return bytes;
  }

  template <typename T>
  T take() {
    T value;
    std::memcpy(&value, take_bytes(sizeof(T)).data(), sizeof(T));
    return value;
  }

  uint64_t take_offset() { return wide_ ? take<uint64_t>() : take<uint32_t>(); }

  /// False at the record of zeros that ends a list of nodes.
  bool parse_node(FbxNode& node, uint64_t limit, int depth) {
    if (depth > kMaxFbxDepth) fail("is nested too deeply", kTruncated);
    const uint64_t end = take_offset(), value_count = take_offset(), value_bytes = take_offset();
    node.name = take_bytes(take<uint8_t>());
    if (end == 0) return false;
    if (end > limit || end < at_ || value_bytes > end - at_ || value_count > value_bytes)
      fail("has a node that ends outside its parent", kTruncated);
    const uint64_t values_end = at_ + value_bytes;
    if (value_count > kMaxFbxSeparateValues) {
      node.values.push_back({'#', take_bytes(value_bytes), static_cast<uint32_t>(value_count), false});
    } else {
      for (uint64_t i = 0; i < value_count; ++i) node.values.push_back(parse_value());
    }
    if (at_ != values_end) fail("has values of a wrong length", kTruncated);
    while (at_ < end) {
      FbxNode child;
      if (!parse_node(child, end, depth + 1)) break;
      node.children.push_back(std::move(child));
    }
    if (at_ != end) fail("has a node of a wrong length", kTruncated);
    return true;
  }

  FbxValue parse_value() {
    FbxValue value;
    value.type = take<char>();
    switch (value.type) {
      case 'C':
        value.bytes = take_bytes(1);
        break;
      case 'Y':
        value.bytes = take_bytes(2);
        break;
      case 'I':
      case 'F':
        value.bytes = take_bytes(4);
        break;
      case 'L':
      case 'D':
        value.bytes = take_bytes(8);
        break;
      case 'S':
      case 'R':
        value.bytes = take_bytes(take<uint32_t>());
        break;
      case 'b':
      case 'i':
      case 'l':
      case 'f':
      case 'd': {
        value.count = take<uint32_t>();
        value.packed = take<uint32_t>() != 0;
        value.bytes = take_bytes(take<uint32_t>());
        break;
      }
      default:
        fail("has a value of an unknown type", kTruncated);
    }
    return value;
  }

  const std::filesystem::path& file_;
  std::string_view content_;
  size_t at_ = 0;
  bool wide_ = false;
};

class AsciiParser {
 public:
  AsciiParser(const std::filesystem::path& file, std::string_view content) : file_(file), content_(content) {}

  FbxTree parse() {
    FbxTree tree;
    tree.version = static_cast<int>(stated_version());
    check_version(file_, "FBXVersion", tree.version);
    parse_nodes(tree.root, 0);
    skip_blanks();
    if (at_ < content_.size()) fail("has a '}' too many");
    if (!tree.root.child("Objects")) fail("has no Objects");
    return tree;
  }

 private:
  [[noreturn]] void fail(const std::string& cause) const {
    size_t line = 1;
    for (size_t i = 0; i < at_ && i < content_.size(); ++i) line += content_[i] == '\n';
    throw InputError(file_.string(), "line " + std::to_string(line), cause, kTruncated);
  }

  /// Looked for before the rest is parsed: other versions may be written in other ways. Without it the
  /// comment at the top ("; FBX 6.1.0 project file") tells, else it is taken as 7.
  int64_t stated_version() const {
    const std::string_view key = "FBXVersion:";
    const size_t found = content_.find(key);
    if (found == std::string_view::npos) {
      const std::string_view top = "; FBX ";
      const bool is_stated = content_.substr(0, top.size()) == top && content_.size() > top.size() + 3;
      const std::string_view number = is_stated ? content_.substr(top.size(), 3) : "7.0";
      return 1000 * (number[0] - '0') + 100 * (number[2] - '0');
    }
    size_t begin = found + key.size();
    while (begin < content_.size() && (content_[begin] == ' ' || content_[begin] == '\t')) ++begin;
    size_t end = begin;
    while (end < content_.size() && end - begin < 9 && content_[end] >= '0' && content_[end] <= '9') ++end;
    long long version = 0;
    return parse_integer(content_.substr(begin, end - begin), version) ? version : 7000;
  }

  static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

  char peek() const { return at_ < content_.size() ? content_[at_] : '\0'; }

  void skip_blanks(bool across_lines = true) {
    while (at_ < content_.size()) {
      if (content_[at_] == ';') {
        while (at_ < content_.size() && content_[at_] != '\n') ++at_;
      } else if (is_blank(content_[at_]) && (across_lines || content_[at_] != '\n')) {
        ++at_;
      } else {
        return;
      }
    }
  }

  std::string_view take_word() {
    const size_t begin = at_;
    while (at_ < content_.size() && !is_blank(content_[at_]) && !std::strchr(",:{};\"", content_[at_])) ++at_;
    return content_.substr(begin, at_ - begin);
  }

  void parse_nodes(FbxNode& parent, int depth) {
    if (depth > kMaxFbxDepth) fail("is nested too deeply");
    for (skip_blanks(); at_ < content_.size() && peek() != '}'; skip_blanks()) {
      FbxNode node;
      node.name = take_word();
      if (node.name.empty() || peek() != ':') fail("has no 'Name:' where a node should begin");
      ++at_;
      parse_values(node);
      if (peek() == '{') parse_block(node, depth);
      parent.children.push_back(std::move(node));
    }
  }

  void parse_block(FbxNode& node, int depth) {
    ++at_;
    const bool is_array = node.values.size() == 1 && node.values[0].type == '*';
    if (is_array) {
      skip_blanks();
      if (content_.substr(at_, 2) != "a:") fail("has an array without numbers");
      at_ += 2;
      const size_t end = content_.find('}', at_);
      if (end == std::string_view::npos) fail("ends within an array");
      node.values[0].bytes = content_.substr(at_, end - at_);
      at_ = end;
    } else {
      parse_nodes(node, depth + 1);
    }
    if (peek() != '}') fail("ends within a node");
    ++at_;
  }

  /// Values up to the end of the line or '{'. They go on where a line ends or the next begins with a comma,
  /// or where they only begin there ("Key: " of version 6).
  void parse_values(FbxNode& node) {
    const size_t begin = at_;
    size_t end = at_;
    for (skip_blanks(false); at_ < content_.size() && goes_on(node.values.empty()); skip_blanks(false)) {
      skip_blanks();
      if (peek() == ',') ++at_;
      skip_blanks();
      const char c = peek();
      if (c == '}' || c == '{' || c == '\0') break;
      const FbxValue value = take_value();
      end = at_;
      if (node.values.size() == kMaxFbxSeparateValues) node.values = {{'*', {}, 0, false}};
      const bool is_list = node.values.size() == 1 && node.values[0].type == '*' && value.type != '*';
      if (!is_list) node.values.push_back(value);
    }
    if (node.values.size() == 1 && node.values[0].type == '*')
      node.values[0].bytes = content_.substr(begin, end - begin);
  }

  /// Whether another value follows: at the first on the line or after a comma.
  bool goes_on(bool is_first) const {
    size_t at = at_;
    const bool ends_line = content_[at] == '\n';
    while (at < content_.size() && is_blank(content_[at])) ++at;
    const char c = at < content_.size() ? content_[at] : '\0';
    if (c == ',') return true;
    if (!is_first || c == '\0' || c == '{' || c == '}') return false;
    return !ends_line || (c >= '0' && c <= '9') || c == '-' || c == '.';
  }

  FbxValue take_value() {
    FbxValue value;
    const char c = peek();
    if (c == '"') {
      const size_t end = content_.find('"', at_ + 1);
      if (end == std::string_view::npos) fail("ends within a text");
      value.type = 'S';
      value.bytes = content_.substr(at_ + 1, end - at_ - 1);
      at_ = end + 1;
    } else if (c == '*') {
      ++at_;
      take_word();
      value.type = '*';
    } else {
      value.type = 'T';
      value.bytes = take_word();
      if (value.bytes.empty()) fail("has a stray character");
    }
    return value;
  }

  const std::filesystem::path& file_;
  std::string_view content_;
  size_t at_ = 0;
};

}  // namespace

FbxTree parse_binary_fbx(const std::filesystem::path& file, std::string_view content) {
  if (content.size() < 27)
    throw InputError(file.string(), "byte " + std::to_string(content.size()), "FBX header is cut off",
                     kTruncated);
  return BinaryParser(file, content).parse();
}

FbxTree parse_ascii_fbx(const std::filesystem::path& file, std::string_view content) {
  if (content.find('\0') != std::string_view::npos ||
      content.find("FBXHeaderExtension") == std::string_view::npos)
    throw InputError(file.string(), "", "is no FBX file", "export the scan as FBX, GLB or OBJ");
  return AsciiParser(file, content).parse();
}

}  // namespace ohb
