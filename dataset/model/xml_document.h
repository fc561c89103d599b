// Strict reading of our XML files. pugixml accepts duplicate attributes, turns "abc" into 0 and reads
// numbers by the C locale; here each of these is an error, or is done by std::from_chars.
#pragma once

#include <pugixml.hpp>

#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <string>
#include <vector>

#include "dataset/model/error.h"

namespace ohb {

/// One parsed file; every error names the file and the line of the element.
class XmlDocument {
 public:
  /// Parses `file`, whose root element must be `root_name`. Throws InputError: no such file, not
  /// well-formed, a document type, nested too deeply, another root.
  XmlDocument(const std::filesystem::path& file, const std::string& root_name);

  pugi::xml_node root() const { return root_; }
  const std::filesystem::path& file() const { return file_; }

  /// The only child of that name. Throws InputError if there is none or more than one.
  pugi::xml_node child(pugi::xml_node parent, const char* name) const;
  /// The attribute's value. Throws InputError if it is missing.
  std::string text(pugi::xml_node node, const char* attribute) const;
  /// As text, or `otherwise` where the attribute is missing.
  std::string text_or(pugi::xml_node node, const char* attribute, const std::string& otherwise) const;
  /// A finite number in [low, high]. Throws InputError.
  double number(pugi::xml_node node, const char* attribute, double low, double high) const;
  /// An integer in [0, high]. Throws InputError.
  uint64_t count(pugi::xml_node node, const char* attribute, uint64_t high) const;
  /// Throws InputError for an attribute that occurs twice or is not in `names`.
  void expect_attributes(pugi::xml_node node, const std::vector<std::string>& names) const;
  /// Throws InputError for a child element that is not in `names`, and for text between the elements.
  void expect_children(pugi::xml_node node, const std::vector<std::string>& names) const;

  /// To throw: "file: line 12: cause; mend".
  InputError error(pugi::xml_node node, const std::string& cause, const std::string& mend) const;

 private:
  std::string line_of(ptrdiff_t offset) const;
  void expect_one_root() const;
  void expect_shallow() const;

  std::filesystem::path file_;
  std::string content_;
  pugi::xml_document document_;
  pugi::xml_node root_;
};

/// The document as text: declaration, two spaces of indent, a newline at the end. What is not UTF-8 in it
/// is read as Latin-1; control characters, which XML has not, become U+FFFD.
std::string xml_text(const pugi::xml_document& document);

/// The shortest text that reads back as the same number, whatever the locale.
std::string shortest(double value);
std::string shortest(float value);

}  // namespace ohb
