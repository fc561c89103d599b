// The conventions that a model.xml or regions.xml states, so that the data explain themselves
// (docs/conventions.md says the same at length).
#pragma once

#include <pugixml.hpp>

#include <array>

namespace ohb {

struct Convention {
  const char* thing;
  const char* rule;
};

/// A reader refuses a file with another version than this.
constexpr int kConventionsVersion = 1;

constexpr std::array<Convention, 14> kConventions = {{
    {"length", "centimetres"},
    {"axes", "right-handed, +Y up, the subject faces +Z, soles at y = 0, bounding box centred at x = z = 0"},
    {"classes", "0 skin, 1 hair, 2 fabric, 3 leather, 255 unlabelled"},
    {"uv",
     "v up; texel of column i and row r from the top is centred at u = (i + 0.5) / width, "
     "v = 1 - (r + 0.5) / height; bilinear, repeated beyond [0,1]"},
    {"albedo", "linear Rec. 709 in EXR, sRGB in PNG"},
    {"alpha", "cut-out opacity, linear, not premultiplied into albedo"},
    {"normal",
     "tangent space, MikkTSpace, +Y up (OpenGL); signed unit vectors as R = x, G = y, B = z in EXR, "
     "(n + 1) / 2 in PNG"},
    {"roughness", "perceptual; GGX alpha = roughness squared"},
    {"specular", "sRGB-encoded normal-incidence reflectance: F0 = srgb_to_linear(S)"},
    {"sss", "Principled subsurface weight; scattering radius = sss x (1.0, 0.2, 0.1) cm"},
    {"displacement", "signed distance in cm from the plane z = 0 in the rest pose, positive towards +Z"},
    {"valid", "PNG 255: a face covers the texel; 128: padding; 0: neither"},
    {"smooth_normals", "sum of triangle normals weighted by corner angle, over shared positions"},
    {"exr", "half for albedo, alpha, normal, roughness, specular and sss; float for displacement"},
}};

/// Appends <conventions version="1"><convention of="length" is="centimetres"/>...</conventions>.
inline void append_conventions(pugi::xml_node parent) {
  pugi::xml_node node = parent.append_child("conventions");
  node.append_attribute("version") = kConventionsVersion;
  for (const Convention& convention : kConventions) {
    pugi::xml_node child = node.append_child("convention");
    child.append_attribute("of") = convention.thing;
    child.append_attribute("is") = convention.rule;
  }
}

}  // namespace ohb
