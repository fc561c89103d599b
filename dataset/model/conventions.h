// The conventions that a model.xml or regions.xml states, so that the data explain themselves
// (docs/conventions.md says the same at length).
#pragma once

#include <pugixml.hpp>

#include <string>
#include <vector>

namespace ohb {

struct Convention {
  std::string thing, rule;
};

/// A reader refuses a file with another version than this.
constexpr int kConventionsVersion = 1;

/// In the order of the files. Those of classes and maps follow kClassNames, kMaterialMaps and kMapKinds.
std::vector<Convention> conventions();

/// Appends <conventions version="1"><convention of="length" is="centimetres"/>...</conventions>.
void append_conventions(pugi::xml_node parent);

}  // namespace ohb
