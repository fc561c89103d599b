// Class maps in UV space, and the mean colour of faces.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dataset/model/scan.h"
#include "dataset/model/vec.h"

namespace ohb {

/// Mean diffuse colour of each face, linear Rec. 709: the average of the texels of its picture whose centre
/// it holds (the one at its middle if it holds none), times the diffuse factor; the factor alone without a
/// picture or without UVs. Throws InputError for a picture that cannot be read.
std::vector<Vec3f> mean_face_colours(const Scan& scan);

/// Writes maps/<material>/classes.png (8 bit: the class index of the face that each texel shows, nearest, 255
/// where there is none) and classes_preview.png (coloured, at most 1024 px) for each material that has faces.
/// Size: that of the diffuse picture, 1024 x 1024 without one, at most 8192. Materials whose UVs are missing
/// or out of range get none; their names are given back.
std::vector<std::string> write_class_maps(const std::filesystem::path& folder, const Scan& scan,
                                          const std::vector<uint8_t>& face_class);

/// sRGB colour of a class in previews; grey for unlabelled.
Vec3f class_colour(uint8_t material_class);

}  // namespace ohb
