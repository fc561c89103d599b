#include "dataset/model/xml_document.h"

#include <utf8proc.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>

#include "dataset/model/atomic_file.h"
#include "dataset/model/foreign_content.h"

namespace ohb {
namespace {

constexpr int kMaxDepth = 64;  // ours have five

std::string utf8_of(utf8proc_int32_t letter) {
  utf8proc_uint8_t bytes[4];
  const utf8proc_ssize_t length = utf8proc_encode_char(letter, bytes);
  return std::string(reinterpret_cast<const char*>(bytes), static_cast<size_t>(length));
}

/// Length of the reference to a control character ("&#01;") that begins there: XML allows none but tab and
/// ends of line, not even as references. 0 for anything else.
size_t forbidden_reference(const std::string& text, size_t at) {
  int code = 0;
  const char *first = text.data() + at + 2, *last = text.data() + text.size();
  if (text.compare(at, 2, "&#") != 0) return 0;
  const auto [end, failure] = std::from_chars(first, last, code);
  if (failure != std::errc() || end == last || *end != ';') return 0;
  const bool is_forbidden = code < 32 && code != '\t' && code != '\n' && code != '\r';
  return is_forbidden ? static_cast<size_t>(end + 1 - text.data()) - at : 0;
}

/// Names come from files as they are: a byte that is no UTF-8 is read as Latin-1, and what XML cannot hold
/// becomes U+FFFD, so that every XML reader takes the text.
std::string well_formed(const std::string& text) {
  std::string result;
  const auto* bytes = reinterpret_cast<const utf8proc_uint8_t*>(text.data());
  for (size_t at = 0; at < text.size();) {
    utf8proc_int32_t letter = 0;
    const utf8proc_ssize_t length =
        utf8proc_iterate(bytes + at, static_cast<utf8proc_ssize_t>(text.size() - at), &letter);
    if (const size_t reference = forbidden_reference(text, at); reference > 0) {
      result += utf8_of(0xFFFD);
      at += reference;
    } else if (length < 0) {
      result += utf8_of(bytes[at++]);
    } else {
      result.append(text, at, static_cast<size_t>(length));
      at += static_cast<size_t>(length);
    }
  }
  return result;
}

}  // namespace

XmlDocument::XmlDocument(const std::filesystem::path& file, const std::string& root_name)
    : file_(file), content_(read_file(file)) {
  if (content_.empty()) throw InputError(file.string(), "", "the file is empty", "make it again");
  refuse_foreign_content(file, std::string_view(content_).substr(0, 512));
  const pugi::xml_parse_result result = document_.load_buffer(
      content_.data(), content_.size(), pugi::parse_default | pugi::parse_doctype | pugi::parse_fragment);
  if (!result)
    throw InputError(file.string(), line_of(result.offset),
                     "not well-formed XML: " + std::string(result.description()), "correct the XML");
  root_ = document_.document_element();
  expect_one_root();
  expect_shallow();
  if (root_.name() != root_name)
    throw error(root_,
                "the root element is <" + std::string(root_.name()) + ">, expected <" + root_name + ">",
                "give a file of the right kind");
}

void XmlDocument::expect_one_root() const {
  for (const pugi::xml_node& node : document_.children()) {
    // Entities that grow (billion laughs) are declared there; pugixml leaves them as they are.
    if (node.type() == pugi::node_doctype)
      throw error(node, "has a document type (<!DOCTYPE ...>), which our files have not",
                  "remove it, and write what its entities stand for");
    if (node.type() == pugi::node_pcdata || node.type() == pugi::node_cdata)
      throw error(node, "not well-formed XML: text outside of the root element", "remove it");
    if (node.type() == pugi::node_element && node != root_)
      throw error(node, "not well-formed XML: a second root element, <" + std::string(node.name()) + ">",
                  "keep one");
  }
  if (!root_) throw error(root_, "not well-formed XML: there is no element", "correct the XML");
}

void XmlDocument::expect_shallow() const {
  int depth = 0;
  for (pugi::xml_node node = document_.first_child(); node && node != document_;) {
    if (node.first_child()) {
      node = node.first_child();
      if (++depth > kMaxDepth)
        throw error(node, "elements are nested deeper than " + std::to_string(kMaxDepth) + " levels",
                    "it is damaged, or no file for this program");
      continue;
    }
    while (!node.next_sibling() && node.parent() != document_) node = node.parent(), --depth;
    node = node.next_sibling();
  }
}

std::string XmlDocument::line_of(ptrdiff_t offset) const {
  const auto end =
      content_.begin() + std::clamp<ptrdiff_t>(offset, 0, static_cast<ptrdiff_t>(content_.size()));
  return "line " + std::to_string(1 + std::count(content_.begin(), end, '\n'));
}

InputError XmlDocument::error(pugi::xml_node node, const std::string& cause, const std::string& mend) const {
  return InputError(file_.string(), line_of(node.offset_debug()), cause, mend);
}

pugi::xml_node XmlDocument::child(pugi::xml_node parent, const char* name) const {
  const pugi::xml_node node = parent.child(name);
  if (!node) throw error(parent, "<" + std::string(parent.name()) + "> has no <" + name + ">", "add it");
  if (node.next_sibling(name))
    throw error(node.next_sibling(name), "a second <" + std::string(name) + ">", "keep one");
  return node;
}

std::string XmlDocument::text(pugi::xml_node node, const char* attribute) const {
  const pugi::xml_attribute found = node.attribute(attribute);
  if (!found)
    throw error(node, "<" + std::string(node.name()) + "> has no attribute '" + attribute + "'", "add it");
  return found.value();
}

std::string XmlDocument::text_or(pugi::xml_node node, const char* attribute,
                                 const std::string& otherwise) const {
  return node.attribute(attribute) ? node.attribute(attribute).value() : otherwise;
}

double XmlDocument::number(pugi::xml_node node, const char* attribute, double low, double high) const {
  const std::string value = text(node, attribute);
  double number = 0;
  const auto [end, failure] = std::from_chars(value.data(), value.data() + value.size(), number);
  if (failure != std::errc() || end != value.data() + value.size() || !std::isfinite(number))
    throw error(node, std::string(attribute) + "=\"" + value + "\" is no number",
                "write one, for example 0.5");
  if (number < low || number > high)
    throw error(node,
                std::string(attribute) + "=\"" + value + "\" is outside [" + shortest(low) + ", " +
                    shortest(high) + "]",
                "give a value in this range");
  return number;
}

uint64_t XmlDocument::count(pugi::xml_node node, const char* attribute, uint64_t high) const {
  const std::string value = text(node, attribute);
  uint64_t number = 0;
  const auto [end, failure] = std::from_chars(value.data(), value.data() + value.size(), number);
  if (failure != std::errc() || end != value.data() + value.size() || number > high)
    throw error(
        node,
        std::string(attribute) + "=\"" + value + "\" is no whole number from 0 to " + std::to_string(high),
        "write one");
  return number;
}

void XmlDocument::expect_attributes(pugi::xml_node node, const std::vector<std::string>& names) const {
  std::vector<std::string> seen;
  for (const pugi::xml_attribute& attribute : node.attributes()) {
    const std::string name = attribute.name();
    if (std::find(names.begin(), names.end(), name) == names.end())
      throw error(node, "<" + std::string(node.name()) + "> has an unknown attribute '" + name + "'",
                  "remove it, or check its spelling");
    if (std::find(seen.begin(), seen.end(), name) != seen.end())
      throw error(node, "attribute '" + name + "' occurs twice", "keep one");
    seen.push_back(name);
  }
}

void XmlDocument::expect_children(pugi::xml_node node, const std::vector<std::string>& names) const {
  for (const pugi::xml_node& child : node.children())
    if (child.type() == pugi::node_pcdata || child.type() == pugi::node_cdata)
      throw error(child, "text inside <" + std::string(node.name()) + ">, where none belongs", "remove it");
  for (const pugi::xml_node& child : node.children())
    if (child.type() == pugi::node_element &&
        std::find(names.begin(), names.end(), std::string(child.name())) == names.end())
      throw error(child, "<" + std::string(child.name()) + "> is not known inside <" + node.name() + ">",
                  "remove it, or check its spelling");
}

std::string xml_text(const pugi::xml_document& document) {
  std::ostringstream stream;
  document.save(stream, "  ");
  return well_formed(stream.str());
}

std::string shortest(double value) {
  char text[32];
  return std::string(text, std::to_chars(text, text + sizeof text, value).ptr);
}

std::string shortest(float value) {
  char text[32];
  return std::string(text, std::to_chars(text, text + sizeof text, value).ptr);
}

}  // namespace ohb
