// EXR files may state the chromaticities of their primaries (ACES, Rec. 2020, P3); our maps are Rec. 709.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "dataset/model/image.h"

namespace ohb::environments {

/// CIE xy of red, green, blue and white, in this order: x, y, x, y, ...
using Chromaticities = std::array<double, 8>;
constexpr Chromaticities kRec709 = {0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290};

/// Row-major 3 x 3: linear RGB of these primaries to linear Rec. 709, white to white (Bradford adaptation of
/// Lindbloom, "Chromatic Adaptation").
std::array<double, 9> to_rec709(const Chromaticities& from);

/// Converts `image` (3 channels) if `file` is an EXR that states other chromaticities than Rec. 709's, and
/// says so in `warnings`. Throws InputError for chromaticities that are no primaries.
void convert_primaries(const std::filesystem::path& file, Image& image, std::vector<std::string>& warnings);

}  // namespace ohb::environments
