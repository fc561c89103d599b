// Pictures as other programs write them, for tests.
#pragma once

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <string>

#include "dataset/model/image.h"

namespace ohb {

/// By OpenImageIO, with what `change` makes of the header.
inline std::filesystem::path write_picture_with(
    const std::filesystem::path& file, const Image& image, OIIO::TypeDesc type,
    const std::function<void(OIIO::ImageSpec&)>& change = [](OIIO::ImageSpec&) {}) {
  OIIO::ImageSpec spec(image.width_px, image.height_px, image.channels, type);
  change(spec);
  const auto output = OIIO::ImageOutput::create(file.string());
  EXPECT_TRUE(output && output->open(file.string(), spec)) << OIIO::geterror();
  const bool is_tiled = spec.tile_width > 0;
  EXPECT_TRUE(is_tiled ? output->write_tiles(spec.x, spec.x + spec.width, spec.y, spec.y + spec.height, 0, 1,
                                             OIIO::TypeDesc::FLOAT, image.values.data())
                       : output->write_image(OIIO::TypeDesc::FLOAT, image.values.data()))
      << output->geterror();
  output->close();
  return file;
}

/// A Radiance picture whose reds are red(x, y), with row 0 at the top, stored as its resolution line says:
/// axes are
/// "-Y", "+X" and their like.
inline std::string radiance_picture(const std::string& first, const std::string& second, int width,
                                    int height, const std::function<uint8_t(int, int)>& red) {
  const auto count = [&](const std::string& axis) { return axis[1] == 'X' ? width : height; };
  const auto place = [&](const std::string& axis, int i) {
    // -Y runs downwards and +X to the right, as rows and columns count.
    return (axis == "-Y" || axis == "+X") ? i : count(axis) - 1 - i;
  };
  std::string bytes = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n" + first + " " + std::to_string(count(first)) +
                      " " + second + " " + std::to_string(count(second)) + "\n";
  for (int i = 0; i < count(first); ++i)
    for (int j = 0; j < count(second); ++j) {
      const int a = place(first, i), b = place(second, j);
      const uint8_t value = first[1] == 'X' ? red(a, b) : red(b, a);
      bytes += static_cast<char>(value);
      bytes += std::string("\x20\x20", 2) + static_cast<char>(136);  // times 1
    }
  return bytes;
}

}  // namespace ohb
