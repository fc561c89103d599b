// Photographs whose colours are not sRGB's: phones write Display P3, cameras Adobe RGB.
#pragma once

#include <filesystem>
#include <string>

#include "dataset/model/image.h"

namespace ohb::learner {

/// The ICC profile in a picture file, as it stands there; "" if there is none. Throws InputError if the file
/// cannot be opened.
std::string colour_profile_of(const std::filesystem::path& file);

enum class ProfileUse { kNone, kIsSrgb, kApplied, kUnreadable };
/// Turns the first three channels of a picture, encoded as the profile says, into sRGB-encoded ones, relative
/// to the white of each (ICC.1:2022, media-relative colorimetric intent). Colours that sRGB has not are
/// clamped to [0, 1]. A profile that gives sRGB's colours within 1/512, that is not of RGB, or that cannot be
/// read leaves the picture alone.
ProfileUse to_srgb(Image& picture, const std::string& profile);

}  // namespace ohb::learner
