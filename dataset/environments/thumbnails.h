// Small pictures of a library's maps, for eyes only.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dataset/model/image.h"

namespace ohb::environments {

constexpr int kThumbnailWidth_px = 256;

std::filesystem::path thumbnail_file(const std::filesystem::path& library, const std::string& id);

/// Radiance to the display: a brightness of its own for each map (the solid-angle mean of the logarithm comes
/// to 0.18, nothing brighter than the mean to less than 0.1), then x (1 + x / 16) / (1 + x) (Reinhard et al.
/// 2002, eq. 4, white at 4) and the sRGB curve.
ByteImage tone_mapped(const Image& map, int width_px);

void write_thumbnail(const std::filesystem::path& library, const std::string& id, const Image& map);

/// LIB/sheet.png: the thumbnails row by row, smaller where there are many. Throws InputError if one is
/// missing.
void write_thumbnail_sheet(const std::filesystem::path& library, const std::vector<std::string>& ids);

}  // namespace ohb::environments
