#include "dataset/exports/tar.h"

#include <cstdio>

#include "dataset/model/error.h"

namespace ohb::exports {
namespace {

constexpr size_t kBlock = 512, kLongestName = 100, kLargest = size_t{1} << 33;

void put(std::string& block, size_t at, const std::string& text) {
  block.replace(at, text.size(), text);
}

std::string octal(size_t value, int digits) {
  char text[32];
  std::snprintf(text, sizeof text, "%0*zo", digits, value);
  return text;
}

}  // namespace

std::string tar_member(const std::string& name, const std::string& content) {
  if (name.size() > kLongestName || content.size() >= kLargest)
    throw InputError(name, "", "does not fit into a tar file",
                     "give people shorter ids, or samples fewer pixels");
  std::string header(kBlock, '\0');
  put(header, 0, name);
  put(header, 100, octal(0644, 7));
  put(header, 108, octal(0, 7));
  put(header, 116, octal(0, 7));
  put(header, 124, octal(content.size(), 11));
  put(header, 136, octal(0, 11));
  put(header, 148, "        ");  // the checksum counts as blanks
  put(header, 156, "0");
  put(header, 257, std::string("ustar\0", 6) + "00");
  size_t sum = 0;
  for (const char c : header) sum += static_cast<unsigned char>(c);
  put(header, 148, octal(sum, 6) + std::string("\0 ", 2));
  return header + content + std::string((kBlock - content.size() % kBlock) % kBlock, '\0');
}

std::string tar_end() {
  return std::string(2 * kBlock, '\0');
}

}  // namespace ohb::exports
