// Class maps in UV space.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dataset/labelling/soft_borders.h"
#include "dataset/labelling/texel_labels.h"
#include "dataset/model/scan.h"
#include "dataset/model/vec.h"

namespace ohb::commands {

/// What the maps show of each face.
struct FaceLabels {
  std::vector<uint8_t> face_class;
  std::vector<float> confidence;                    // in [0,1]; empty: not known
  const labelling::SoftBorders* borders = nullptr;  // null: no weights
  const labelling::TexelLabels* texels = nullptr;   // null: each texel has the class of its face
  double unit_cm = 1;                               // cm a unit of the scan; for `texels`
};

/// Writes into maps/<material>, for each material that has faces, at the size of its diffuse picture
/// (1024 x 1024 without one, at most 8192):
/// - classes.png: 8 bit, the class index at each texel, or of the face that it shows, 255 where there is
/// none;
/// - classes_preview.png: the same coloured, at most 1024 px;
/// - weights.exr, with borders: half, the shares of skin, hair, fabric and leather at each texel; all 0 where
///   there is no face or no class;
/// - confidence.png, with confidence: 8 bit, 255 is sure, and where there is no face.
/// Materials whose UVs are missing or out of range get none; their names are given back.
std::vector<std::string> write_class_maps(const std::filesystem::path& folder, const Scan& scan,
                                          const FaceLabels& labels);

/// sRGB colour of a class in previews; grey for unlabelled.
Vec3f class_colour(uint8_t material_class);

}  // namespace ohb::commands
