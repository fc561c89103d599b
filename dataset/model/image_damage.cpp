#include "dataset/model/image_damage.h"

#include <zlib.h>

#include <algorithm>
#include <cstdint>

namespace ohb {
namespace {

uint32_t big_endian(std::string_view bytes, size_t at, int count) {
  uint32_t value = 0;
  for (int i = 0; i < count; ++i)
    value = value << 8 | static_cast<unsigned char>(bytes[at + static_cast<size_t>(i)]);
  return value;
}

std::string at_byte(const std::string& what, size_t at) {
  return what + " at byte " + std::to_string(at);
}

}  // namespace

std::string png_damage(std::string_view bytes) {
  size_t at = 8;  // behind the signature
  while (bytes.size() >= 12 && at <= bytes.size() - 12) {
    const size_t length = big_endian(bytes, at, 4);
    const std::string_view kind = bytes.substr(at + 4, 4);
    if (length > bytes.size() - at - 12) break;
    const auto* checked = reinterpret_cast<const Bytef*>(bytes.data() + at + 4);
    const uint32_t sum = static_cast<uint32_t>(crc32(0, checked, static_cast<uInt>(length + 4)));
    if (sum != big_endian(bytes, at + 8 + length, 4)) return at_byte("damaged: wrong checksum", at);
    if (kind == "IEND") return "";
    at += length + 12;
  }
  return at_byte("truncated: it ends", bytes.size());
}

std::string jpeg_damage(std::string_view bytes) {
  size_t at = 2;  // behind the start marker
  while (at + 1 < bytes.size()) {
    const auto byte = [&](size_t i) { return static_cast<unsigned char>(bytes[i]); };
    if (byte(at) != 0xff) return at_byte("damaged: no marker", at);
    const unsigned marker = byte(at + 1);
    if (marker == 0xff) {  // padding
      ++at;
      continue;
    }
    if (marker == 0xd9) return "";  // end of image
    if (marker == 0x01 || (marker >= 0xd0 && marker <= 0xd7)) {
      at += 2;
      continue;
    }
    if (at + 4 > bytes.size()) break;
    const size_t length = big_endian(bytes, at + 2, 2);
    if (length < 2) return at_byte("damaged: segment without length", at);
    at += 2 + length;
    if (marker != 0xda) continue;
    // Coded data up to the next marker that is neither a stuffed zero nor a restart.
    while (at + 1 < bytes.size() &&
           !(byte(at) == 0xff && byte(at + 1) != 0 && !(byte(at + 1) >= 0xd0 && byte(at + 1) <= 0xd7)))
      ++at;
  }
  return at_byte("truncated: it ends", bytes.size());
}

bool speaks_of_damage(std::string_view words) {
  while (!words.empty()) {
    const std::string_view line = words.substr(0, words.find('\n'));
    const auto says = [&](std::string_view part) { return line.find(part) != std::string_view::npos; };
    if (says("TIFFRead") || (says("Corrupt JPEG data") && !says("extraneous bytes"))) return true;
    words.remove_prefix(std::min(words.size(), line.size() + 1));
  }
  return false;
}

}  // namespace ohb
