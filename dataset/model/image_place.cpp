#include "dataset/model/image_place.h"

#include <algorithm>

#include "dataset/model/text_lines.h"

namespace ohb {
namespace {

/// "-Y 512 +X 1024"
bool parse_resolution(std::string_view line, HdrLayout& layout) {
  std::string_view rest = line;
  const std::string_view first = next_word(rest), scanlines = next_word(rest), second = next_word(rest),
                         pixels = next_word(rest);
  if (!parse_integer(scanlines, layout.scanlines) || !parse_integer(pixels, layout.scanline_pixels))
    return false;
  // Where the first scanline lies, and the first pixel of each: row 0 and column 0 in the words of TIFF 6.0.
  constexpr struct {
    const char *first, *second;
  } kAxes[8] = {{"-Y", "+X"}, {"-Y", "-X"}, {"+Y", "-X"}, {"+Y", "+X"},
                {"+X", "-Y"}, {"-X", "-Y"}, {"-X", "+Y"}, {"+X", "+Y"}};
  for (int i = 0; i < 8; ++i)
    if (first == kAxes[i].first && second == kAxes[i].second) layout.orientation = i + 1;
  return layout.orientation > 0;
}

}  // namespace

Image upright(const Image& image, int orientation) {
  if (orientation < 2 || orientation > 8) return image;
  const bool swapped = orientation >= 5;
  Image out(swapped ? image.height_px : image.width_px, swapped ? image.width_px : image.height_px,
            image.channels);
  const int right = image.width_px - 1, bottom = image.height_px - 1;
  for (int y = 0; y < out.height_px; ++y)
    for (int x = 0; x < out.width_px; ++x) {
      // Where the upright pixel is stored.
      const int i = swapped ? y : x, j = swapped ? x : y;
      const bool from_right = orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
      const bool from_bottom = orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
      const float* pixel = image.pixel(from_right ? right - i : i, from_bottom ? bottom - j : j);
      std::copy(pixel, pixel + image.channels, out.pixel(x, y));
    }
  return out;
}

HdrLayout hdr_layout(std::string_view start) {
  HdrLayout layout;
  bool is_header = true;
  while (!start.empty()) {
    const size_t end = start.find('\n');
    const std::string_view line = start.substr(0, end);
    start = end == std::string_view::npos ? std::string_view() : start.substr(end + 1);
    if (!is_header) {
      parse_resolution(line, layout);
      break;
    }
    layout.is_xyz |= line.find("32-bit_rle_xyze") != std::string_view::npos;
    is_header = !line.empty();
  }
  return layout;
}

Image placed(Image stored, const PixelWindow& window) {
  if (window.x_px == 0 && window.y_px == 0 && window.width_px == stored.width_px &&
      window.height_px == stored.height_px)
    return stored;
  Image whole(window.width_px, window.height_px, stored.channels);
  const long long left = std::max(0, window.x_px),
                  right = std::min<long long>(window.width_px, 0LL + window.x_px + stored.width_px);
  for (int y = 0; y < stored.height_px && left < right; ++y) {
    const long long row = 0LL + window.y_px + y;
    if (row < 0 || row >= window.height_px) continue;
    const float* from = stored.pixel(static_cast<int>(left - window.x_px), y);
    std::copy(from, from + (right - left) * stored.channels,
              whole.pixel(static_cast<int>(left), static_cast<int>(row)));
  }
  return whole;
}

}  // namespace ohb
