// Small encoded pictures, for tests.
#pragma once

#include <string>

#include "dataset/model/atomic_file.h"
#include "tests/support/scan_files.h"
#include "tests/support/test_files.h"

namespace ohb {

/// The bytes of a PNG or EXR (by the name's ending) of that many pixels squared.
inline std::string picture_bytes(const std::string& name, int size_px = 64) {
  const TemporaryFolder folder;
  if (name.find(".exr") != std::string::npos) {
    write_exr(folder / name, {{"", {"R", "G", "B"}, ExrPart::Type::kHalf, Image(size_px, size_px, 3)}}, {});
  } else {
    write_small_png(folder / name, 3, size_px);
  }
  return read_file(folder / name);
}

/// A baseline JPEG of 16 x 16 grey pixels, made by hand.
inline std::string small_jpeg() {
  std::string bytes("\xff\xd8\xff\xdb\0\x43\0", 7);
  bytes += std::string(64, '\1');
  bytes += std::string("\xff\xc0\0\x0b\x08\0\x10\0\x10\1\1\x11\0", 13);
  bytes += std::string("\xff\xc4\0\x14\0\1", 6) + std::string(15, '\0') + std::string(1, '\0');
  bytes += std::string("\xff\xc4\0\x14\x10\1", 6) + std::string(15, '\0') + std::string(1, '\0');
  bytes += std::string("\xff\xda\0\x08\1\1\0\0\x3f\0", 10);
  bytes += std::string("\0\xff\xd9", 3);  // four blocks of two bits each: no DC difference, end of block
  return bytes;
}

}  // namespace ohb
