// The maps in one place: those that a class's material decides, and those of a sample. Baking, rendering,
// previews, checks, exports, conventions and the Python reader go over these lists.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "dataset/model/material_table.h"
#include "dataset/model/model.h"
#include "dataset/model/sample.h"

namespace ohb {

/// A map of one number in [0, 1] that each class states: an attribute in materials.xml, a UV map of a model
/// and a part of a sample.
struct MaterialMap {
  const char* name;  // of all of these
  float ClassMaterial::*value;
  Image TextureSet::*texels;  // may be empty in models made in memory: 0 everywhere
  Image Sample::*pixels;
  const char* encoding;  // that materials.xml must state as <name>_encoding
  const char* rule;      // what the numbers mean
};

/// In the order of the files.
constexpr std::array<MaterialMap, 3> kMaterialMaps = {{
    {"roughness", &ClassMaterial::roughness, &TextureSet::roughness, &Sample::roughness, "perceptual",
     "perceptual; GGX alpha = roughness squared"},
    {"specular", &ClassMaterial::specular, &TextureSet::specular, &Sample::specular, "srgb-f0",
     "sRGB-encoded normal-incidence reflectance: F0 = srgb_to_linear(S)"},
    {"sss", &ClassMaterial::sss, &TextureSet::sss, &Sample::sss, "weight-1.0-0.2-0.1-cm",
     "Principled subsurface weight; scattering radius = sss x (1.0, 0.2, 0.1) cm"},
}};

/// How a map's values become numbers in [0, 1] of a PNG.
enum class PngEncoding {
  kNone,    // it is not shown
  kPlain,   // as they are
  kSrgb,    // linear colours
  kSigned,  // 0.5 + v / 2
  kLength   // 0.5 + v / (2 range), the range in cm being ohb:displacementRange_cm
};
/// Not clamped, but for kSrgb.
float png_value(PngEncoding encoding, float value, float range_cm);

/// A part of a sample.
struct SampleMap {
  std::string name;
  Image Sample::*image;
  std::vector<std::string> channels;  // names in EXR, in the order of the image's
  ExrPart::Type type;
  PngEncoding png;
  std::string unit, meaning;  // for readers in other languages
};

/// All parts before the lights, in the order of the file.
const std::vector<SampleMap>& sample_maps();

}  // namespace ohb
