#include "dataset/model/material_table.h"

#include "dataset/model/xml_document.h"

namespace ohb {
namespace {

void expect_encoding(const XmlDocument& xml, pugi::xml_node node, const char* attribute,
                     const std::string& known) {
  const std::string encoding = xml.text(node, attribute);
  if (encoding != known)
    throw xml.error(node, std::string(attribute) + "=\"" + encoding + "\" is not known",
                    "convert the values to \"" + known + "\"");
}

}  // namespace

MaterialTable read_material_table(const std::filesystem::path& file) {
  const XmlDocument xml(file, "materials");
  return read_material_table(xml, xml.root());
}

MaterialTable read_material_table(const XmlDocument& xml, pugi::xml_node parent) {
  xml.expect_attributes(parent, {"schema", "specular_encoding", "roughness_encoding", "sss_encoding"});
  xml.expect_children(parent, {"material"});
  expect_encoding(xml, parent, "specular_encoding", "srgb-f0");
  expect_encoding(xml, parent, "roughness_encoding", "perceptual");
  expect_encoding(xml, parent, "sss_encoding", "weight-1.0-0.2-0.1-cm");
  MaterialTable table{};
  std::array<bool, kClassCount> is_given{};
  for (const pugi::xml_node& node : parent.children("material")) {
    xml.expect_attributes(node, {"class", "specular", "roughness", "sss"});
    const std::string name = xml.text(node, "class");
    const MaterialClass index = class_from_name(name);
    if (index == kUnlabelled)
      throw xml.error(node, "class=\"" + name + "\" is not known", "use skin, hair, fabric or leather");
    if (is_given[index]) throw xml.error(node, "a second material for class '" + name + "'", "keep one");
    is_given[index] = true;
    table[index] = {static_cast<float>(xml.number(node, "specular", 0, 1)),
                    static_cast<float>(xml.number(node, "roughness", 0, 1)),
                    static_cast<float>(xml.number(node, "sss", 0, 1))};
  }
  for (int c = 0; c < kClassCount; ++c)
    if (!is_given[c])
      throw xml.error(parent, "there is no material for class '" + std::string(kClassNames[c]) + "'",
                      "add <material class=\"" + std::string(kClassNames[c]) + "\" .../>");
  return table;
}

}  // namespace ohb
