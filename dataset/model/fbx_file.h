// The container of FBX 6 and 7 (binary and ASCII): a tree of named nodes with values. What the nodes mean is
// scan_fbx.cpp's matter. Arrays stay packed until they are asked for, so memory stays near the file's size.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace ohb {

struct FbxValue {
  /// Binary: the type byte of the file (C Y I L F D S R; b i l f d arrays).
  /// ASCII: 'S' quoted, 'T' a bare word or number, '*' an array's numbers as text.
  /// '#': many values one after the other, each with its type byte (version 6 has no arrays).
  char type = 0;
  std::string_view bytes;  // payload, in FbxFile's memory; packed if `packed`
  uint32_t count = 0;      // elements of an array
  bool packed = false;     // zlib
};

struct FbxNode {
  std::string_view name;
  std::vector<FbxValue> values;
  std::vector<FbxNode> children;

  /// The first child of that name, or null.
  const FbxNode* child(std::string_view child_name) const;
};

struct FbxTree {
  FbxNode root;
  int version = 0;
};

class FbxFile {
 public:
  /// Throws InputError (with the byte or line) for anything malformed or truncated.
  explicit FbxFile(const std::filesystem::path& file);
  FbxFile(const FbxFile&) = delete;
  FbxFile& operator=(const FbxFile&) = delete;

  const FbxNode& root() const { return tree_.root; }
  /// 6000 to 7900.
  int version() const { return tree_.version; }
  bool is_binary() const;
  /// The bytes of a picture that the file embeds (binary, or base64 in ASCII files); empty if there are none.
  /// Throws InputError for text that is no base64.
  std::string embedded_bytes(const FbxNode& content) const;
  const std::filesystem::path& path() const { return file_; }

  /// Value `index` of the node in the asked-for kind. Throw InputError if it is not there or of another kind.
  std::string text(const FbxNode& node, size_t index) const;
  int64_t integer(const FbxNode& node, size_t index) const;
  double number(const FbxNode& node, size_t index) const;
  /// The node's array, or its values where it has none (version 6). Throws InputError for damaged packing and
  /// for more elements than a scan may have.
  std::vector<double> numbers(const FbxNode& node) const;

  [[noreturn]] void fail(const std::string& place, const std::string& cause, const std::string& mend) const;

 private:
  void check_room(const FbxNode& node, size_t count) const;
  std::vector<double> text_numbers(const FbxNode& node, const FbxValue& value) const;
  std::vector<double> listed_numbers(const FbxNode& node, const FbxValue& value) const;
  std::vector<double> array_numbers(const FbxNode& node, const FbxValue& value) const;

  std::filesystem::path file_;
  std::string content_;
  FbxTree tree_;
};

/// The parsers of the two encodings; views point into `content`. Throw InputError naming `file`.
FbxTree parse_binary_fbx(const std::filesystem::path& file, std::string_view content);
FbxTree parse_ascii_fbx(const std::filesystem::path& file, std::string_view content);

/// Nodes deeper than this are refused: real files have fewer than ten levels.
constexpr int kMaxFbxDepth = 64;
/// Nodes with more values than this keep them as one list.
constexpr size_t kMaxFbxSeparateValues = 64;

}  // namespace ohb
