// OpenEXR's own reader for the commonest case; all others go by OpenImageIO (image.cpp).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dataset/model/image.h"

namespace ohb {

/// Fills `image`, whose size and channels must be those of the file's only part, which must hold rows of
/// halves. False where the file names its channels otherwise. Takes two thirds of OpenImageIO's time. Throws
/// std::exception where the file is damaged.
bool read_half_rows(const std::filesystem::path& file, const std::vector<std::string>& channels,
                    Image& image);

}  // namespace ohb
