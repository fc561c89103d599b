// Finds pictures that were cut off or damaged though a decoder papers over it: libjpeg fills the missing part
// of a picture with grey, libpng prints to stderr, and OpenImageIO's TIFF reader goes on behind a strip that
// it could not read.
#pragma once

#include <string>
#include <string_view>

namespace ohb {

/// What is wrong with the file, with the place, or "" if it is whole. PNG: the chunks up to IEND and their
/// checksums. JPEG: the markers up to the end of the image. Does not decode.
std::string png_damage(std::string_view bytes);
std::string jpeg_damage(std::string_view bytes);

/// Whether OpenImageIO's words after it read a picture are of pixels that it made up. They may be of no harm,
/// as stray bytes between a JPEG's segments are.
bool speaks_of_damage(std::string_view words);

}  // namespace ohb
