// What differs between OpenImageIO 2.4 and 3 (no other file includes its version).
#pragma once

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <OpenImageIO/oiioversion.h>

#include <string>

namespace ohb {

/// Reads one sub-image's channels [0, channels) as float into `values`; false on failure.
inline bool read_subimage(OIIO::ImageInput& input, int subimage, int channels, float* values) {
  return input.read_image(subimage, 0, 0, channels, OIIO::TypeDesc::FLOAT, values);
}

inline std::string oiio_error(OIIO::ImageInput* input) {
  return input ? input->geterror() : OIIO::geterror();
}

inline std::string oiio_version() {
  return OIIO_VERSION_STRING;
}

}  // namespace ohb
