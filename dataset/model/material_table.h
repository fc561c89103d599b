// The value of each map of kMaterialMaps for each class (paper, table of materials; assets/materials.xml).
#pragma once

#include <array>
#include <filesystem>

#include "dataset/model/regions.h"

namespace pugi {
class xml_node;
}

namespace ohb {

class XmlDocument;

/// What a class is made of, in the encodings of the maps (docs/conventions.md).
struct ClassMaterial {
  float specular = 0;   // S: sRGB-encoded normal-incidence reflectance, F0 = srgb_to_linear(S)
  float roughness = 0;  // perceptual, alpha = roughness squared
  float sss = 0;        // subsurface; scattering radius = sss x (1.0, 0.2, 0.1) cm
};

using MaterialTable = std::array<ClassMaterial, kClassCount>;

/// Reads materials.xml. Throws InputError: missing class, value that is no number or outside [0,1],
/// an encoding other than the ones this version knows.
MaterialTable read_material_table(const std::filesystem::path& file);
/// The same from an element of another file, of the form of materials.xml's root.
MaterialTable read_material_table(const XmlDocument& xml, pugi::xml_node parent);

/// Appends <material class="skin" specular=... roughness=... sss=.../>, one a class, in the order of
/// kClassNames.
void append_materials(pugi::xml_node parent, const MaterialTable& table);

}  // namespace ohb
