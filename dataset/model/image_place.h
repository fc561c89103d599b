// How a file lays its pixels out: turned by an orientation, or as a window that is a part of its picture.
#pragma once

#include <string_view>

#include "dataset/model/image.h"

namespace ohb {

/// The image turned upright: EXIF orientation 1 to 8 (row 0 and column 0 as TIFF 6.0 defines them).
Image upright(const Image& image, int orientation);

/// What the resolution line of a Radiance picture says ("-Y 512 +X 1024" and its seven siblings). The first
/// axis is that of the scanlines, the sign says which way they follow each other: -Y is downwards.
struct HdrLayout {
  int orientation = 0;                           // as EXIF numbers it; 0: there is no such line
  long long scanlines = 0, scanline_pixels = 0;  // as stored
  bool is_xyz = false;                           // FORMAT=32-bit_rle_xyze
};
/// `start`: the file's first bytes, at least up to the resolution line.
HdrLayout hdr_layout(std::string_view start);

/// Where the stored pixels lie in the picture that the file means (OpenEXR: data and display window).
struct PixelWindow {
  int x_px = 0, y_px = 0;           // of the first stored pixel, from the picture's upper left corner
  int width_px = 0, height_px = 0;  // of the picture
};
/// The whole picture: 0 in every channel where nothing is stored, and without what is stored outside it.
Image placed(Image stored, const PixelWindow& window);

}  // namespace ohb
