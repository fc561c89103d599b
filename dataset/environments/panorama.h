// Panoramas as they are found: read, checked and mended before they enter a library.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dataset/model/image.h"

namespace ohb::environments {

/// Linear Rec. 709 radiance, 3 channels, as Environment (dataset/model/environment.h), all values finite and
/// at least 0, not all 0.
struct Panorama {
  Image radiance;
  std::string sha256;  // of the file
  std::string values;  // how the file stored them: "half", "float", "8 bits", ...
  // Texels that were mended:
  size_t nan = 0;       // NaN or -infinite: the mean of their finite neighbours
  size_t infinite = 0;  // the brightest finite value, at least 65504
  size_t negative = 0;  // 0
  std::vector<std::string> warnings;
};

/// PNG, JPEG, TIFF, EXR or HDR, turned upright as the file says. Integers are decoded from sRGB, unless the
/// file says that they are linear, with a warning. EXR colours of other primaries (the chromaticities that
/// the file states) are converted. Throws InputError: no image; not 2:1 within 1 % (with what it may be
/// instead); more than 1 % of the texels NaN or infinite; negative values of more than 1 % of the light; all
/// black.
Panorama read_panorama(const std::filesystem::path& file);

}  // namespace ohb::environments
