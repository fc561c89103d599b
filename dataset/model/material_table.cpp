#include "dataset/model/material_table.h"

#include "dataset/model/map_table.h"
#include "dataset/model/xml_document.h"

namespace ohb {
namespace {

std::string encoding_of(const MaterialMap& map) {
  return std::string(map.name) + "_encoding";
}

void expect_encoding(const XmlDocument& xml, pugi::xml_node node, const MaterialMap& map) {
  const std::string attribute = encoding_of(map), known = map.encoding;
  const std::string encoding = xml.text(node, attribute.c_str());
  if (encoding != known)
    throw xml.error(node, attribute + "=\"" + encoding + "\" is not known",
                    "convert the values to \"" + known + "\"");
}

}  // namespace

MaterialTable read_material_table(const std::filesystem::path& file) {
  const XmlDocument xml(file, "materials");
  return read_material_table(xml, xml.root());
}

MaterialTable read_material_table(const XmlDocument& xml, pugi::xml_node parent) {
  std::vector<std::string> encodings = {"schema"}, columns = {"class"};
  for (const MaterialMap& map : kMaterialMaps) {
    encodings.push_back(encoding_of(map));
    columns.emplace_back(map.name);
  }
  xml.expect_attributes(parent, encodings);
  xml.expect_children(parent, {"material"});
  for (const MaterialMap& map : kMaterialMaps) expect_encoding(xml, parent, map);
  MaterialTable table{};
  std::array<bool, kClassCount> is_given{};
  for (const pugi::xml_node& node : parent.children("material")) {
    xml.expect_attributes(node, columns);
    const std::string name = xml.text(node, "class");
    const MaterialClass index = class_from_name(name);
    if (index == kUnlabelled)
      throw xml.error(node, "class=\"" + name + "\" is not known", "use " + class_list());
    if (is_given[index]) throw xml.error(node, "a second material for class '" + name + "'", "keep one");
    is_given[index] = true;
    for (const MaterialMap& map : kMaterialMaps)
      table[index].*map.value = static_cast<float>(xml.number(node, map.name, 0, 1));
  }
  for (int c = 0; c < kClassCount; ++c)
    if (!is_given[c])
      throw xml.error(parent, "there is no material for class '" + std::string(kClassNames[c]) + "'",
                      "add <material class=\"" + std::string(kClassNames[c]) + "\" .../>");
  return table;
}

void append_materials(pugi::xml_node parent, const MaterialTable& table) {
  for (int c = 0; c < kClassCount; ++c) {
    pugi::xml_node node = parent.append_child("material");
    const pugi::xml_attribute name = node.append_attribute("class");
    node.attribute("class") = kClassNames[c];
    for (const MaterialMap& map : kMaterialMaps) {
      // Specular first, as since the first version: what `produce` has done is known by this text.
      const bool is_first = map.value == &ClassMaterial::specular;
      pugi::xml_attribute value =
          is_first ? node.insert_attribute_after(map.name, name) : node.append_attribute(map.name);
      value = shortest(table[c].*map.value).c_str();
    }
  }
}

}  // namespace ohb
