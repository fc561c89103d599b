// A sample as pictures: what PNG values stand for.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "dataset/model/sample.h"

namespace ohb::exports {

/// Values in [0, 1] as PNG stores them; background 0 (mask says where).
struct EncodedMap {
  std::string name;  // "mask", "normal", ..., "relit_<light>"
  Image image;       // 1 or 3 channels
};
/// Throws InputError, naming `file`: a light whose name is no file name, or no displacement range.
std::vector<EncodedMap> encoded_maps(const Sample& sample, const std::string& file);

/// Radius r in cm of the displacement's encoding, 0.5 + d / (2 r). Throws InputError if the sample states
/// none.
float displacement_range_cm(const Sample& sample, const std::string& file);

/// What the values mean, as a table of Markdown.
std::string encodings_text(int bits);

/// The picture at most `size_px` wide, by area, 1 channel as grey; 8 bits.
ByteImage thumbnail(const Image& image, int size_px);

}  // namespace ohb::exports
