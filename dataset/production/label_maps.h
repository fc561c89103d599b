// Class maps in UV space.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dataset/model/scan.h"
#include "dataset/model/vec.h"

namespace ohb {

/// Writes maps/<material>/classes.png (8 bit: the class index of the face that each texel shows, nearest, 255
/// where there is none) and classes_preview.png (coloured, at most 1024 px) for each material that has faces.
/// Size: that of the diffuse picture, 1024 x 1024 without one, at most 8192. Materials whose UVs are missing
/// or out of range get none; their names are given back. With `confidence` (in [0,1], a number a face) also
/// confidence.png (8 bit, 255: sure, and where there is no face).
std::vector<std::string> write_class_maps(const std::filesystem::path& folder, const Scan& scan,
                                          const std::vector<uint8_t>& face_class,
                                          const std::vector<float>& confidence = {});

/// sRGB colour of a class in previews; grey for unlabelled.
Vec3f class_colour(uint8_t material_class);

}  // namespace ohb
