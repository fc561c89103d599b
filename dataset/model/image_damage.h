// Finds PNG and JPEG files that were cut off or damaged before a decoder papers over it: libjpeg fills the
// missing part of a picture with grey, libpng prints to stderr.
#pragma once

#include <string>
#include <string_view>

namespace ohb {

/// What is wrong with the file, with the place, or "" if it is whole. PNG: the chunks up to IEND and their
/// checksums. JPEG: the markers up to the end of the image. Does not decode.
std::string png_damage(std::string_view bytes);
std::string jpeg_damage(std::string_view bytes);

}  // namespace ohb
