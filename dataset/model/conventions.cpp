#include "dataset/model/conventions.h"

#include "dataset/model/map_table.h"
#include "dataset/model/model_files.h"

namespace ohb {
namespace {

std::string numbered_classes() {
  std::string text;
  for (int c = 0; c < kClassCount; ++c) text += std::to_string(c) + " " + kClassNames[c] + ", ";
  return text + std::to_string(kUnlabelled) + " unlabelled";
}

/// "a, b and c": the kinds that are stored in float, or in half.
std::string kinds_in(bool is_float) {
  std::vector<std::string> names;
  for (const MapKind& kind : kMapKinds)
    if (kind.is_float == is_float) names.emplace_back(kind.name);
  std::string text;
  for (size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
  return text;
}

}  // namespace

std::vector<Convention> conventions() {
  std::vector<Convention> all = {
      {"length", "centimetres"},
      {"axes",
       "right-handed, +Y up, the subject faces +Z, soles at y = 0, bounding box centred at x = z = 0"},
      {"classes", numbered_classes()},
      {"uv",
       "v up; texel of column i and row r from the top is centred at u = (i + 0.5) / width, "
       "v = 1 - (r + 0.5) / height; bilinear, repeated beyond [0,1]"},
      {"albedo", "linear Rec. 709 in EXR, sRGB in PNG"},
      {"alpha", "cut-out opacity, linear, not premultiplied into albedo"},
      {"normal",
       "tangent space, MikkTSpace, +Y up (OpenGL); signed unit vectors as R = x, G = y, B = z in EXR, "
       "(n + 1) / 2 in PNG"}};
  for (const MaterialMap& map : kMaterialMaps) all.push_back({map.name, map.rule});
  all.push_back(
      {"displacement", "signed distance in cm from the plane z = 0 in the rest pose, positive towards +Z"});
  all.push_back({"valid", "PNG 255: a face covers the texel; 128: padding; 0: neither"});
  all.push_back(
      {"smooth_normals", "sum of triangle normals weighted by corner angle, over shared positions"});
  all.push_back({"exr", "half for " + kinds_in(false) + "; float for " + kinds_in(true)});
  return all;
}

void append_conventions(pugi::xml_node parent) {
  pugi::xml_node node = parent.append_child("conventions");
  node.append_attribute("version") = kConventionsVersion;
  for (const Convention& convention : conventions()) {
    pugi::xml_node child = node.append_child("convention");
    child.append_attribute("of") = convention.thing.c_str();
    child.append_attribute("is") = convention.rule.c_str();
  }
}

}  // namespace ohb
