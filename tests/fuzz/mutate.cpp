#include "tests/fuzz/mutate.h"

#include <zlib.h>

#include <algorithm>
#include <cstring>

namespace ohb {
namespace {

size_t below(std::mt19937& random, size_t n) {
  return n > 0 ? static_cast<size_t>(random() % n) : 0;
}

template <size_t N>
std::string one_of(const std::string (&list)[N], std::mt19937& random) {
  return list[below(random, N)];
}

void flip(std::string& bytes, std::mt19937& random) {
  static const std::string edges("\0\xff\x7f\x80 0-9.{}[]\"<>/#\n", 20);
  char& byte = bytes[below(random, bytes.size())];
  switch (random() % 3) {
    case 0:
      byte = static_cast<char>(random());
      break;
    case 1:
      byte = edges[below(random, edges.size())];
      break;
    default:
      byte = static_cast<char>(byte ^ (1 << (random() % 8)));
  }
}

/// A 16, 32 or 64-bit number at an edge of its type, in either byte order.
void write_number(std::string& bytes, std::mt19937& random) {
  constexpr uint64_t kEdges[] = {0,
                                 1,
                                 2,
                                 0x7f,
                                 0xff,
                                 0x7fff,
                                 0xffff,
                                 0x10000,
                                 0x7fffffff,
                                 0x80000000,
                                 0xffffffff,
                                 0xfffffff0,
                                 0x100000000,
                                 0x7fffffffffffffff,
                                 0x8000000000000000,
                                 ~0ull};
  uint64_t value = kEdges[below(random, std::size(kEdges))];
  const size_t size = size_t{2} << (random() % 3), at = below(random, bytes.size());
  const bool is_big_endian = random() % 2;
  for (size_t i = 0; i < size && at + i < bytes.size(); ++i)
    bytes[at + i] = static_cast<char>(value >> 8 * (is_big_endian ? size - 1 - i : i));
}

/// A word that readers of numbers, XML or JSON trip over; one in ten is very long or deeply nested.
std::string odd_word(std::mt19937& random) {
  // clang-format off
  static const std::string words[] = {
      "nan", "inf", "-inf", "1e309", "-1", "0", "1e-320", "4294967296", "99999999999999999999",
      "-9223372036854775809", "0x7f", ".", "-", "\"", "\\", "{", "}", "[", "]", "<", ">", "&#x110000;", "&",
      "%s%n", "../..", "\n", "\r", "\t", " ", "/", "//", "\xff\xfe", "\xc3", "null", "true", "1,5", "#"};
  // clang-format on
  std::string word = one_of(words, random);
  switch (random() % 40) {
    case 0:
      word = std::string(5000, 'A');
      break;
    case 1:
      word = std::string(100000, '[');
      break;
    case 2:
      word.clear();
      for (int i = 0; i < 20000; ++i) word += "{\"a\":";
      break;
    case 3:
      word.clear();
      for (int i = 0; i < 20000; ++i) word += "<a>";
      break;
    default:
      break;
  }
  return word;
}

void insert_word(std::string& bytes, std::mt19937& random) {
  const std::string word = odd_word(random);
  const size_t at = below(random, bytes.size());
  // Instead of something, or between.
  bytes.replace(at, random() % 2 ? std::min(bytes.size() - at, word.size()) : 0, word);
}

/// Replaces one of the text's numbers.
void change_number(std::string& bytes, std::mt19937& random) {
  static const std::string numbers[] = {"0",
                                        "-1",
                                        "1",
                                        "2",
                                        "3.5",
                                        "255",
                                        "256",
                                        "65536",
                                        "2147483648",
                                        "4294967295",
                                        "18446744073709551616",
                                        "1e300",
                                        "-1e300",
                                        "1e-300",
                                        "nan",
                                        "inf",
                                        ""};
  const size_t start = bytes.find_first_of("0123456789", below(random, bytes.size()));
  if (start == std::string::npos) return;
  const size_t end = std::min(bytes.find_first_not_of("0123456789.", start), bytes.size());
  bytes.replace(start, end - start, one_of(numbers, random));
}

void move_block(std::string& bytes, std::mt19937& random) {
  const size_t from = below(random, bytes.size()), to = below(random, bytes.size());
  const std::string block = bytes.substr(from, 1 + below(random, std::min<size_t>(bytes.size(), 200)));
  switch (random() % 3) {
    case 0:
      bytes.erase(from, block.size());
      break;
    case 1:
      bytes.insert(to, block);
      break;
    default:
      bytes.replace(to, std::min(block.size(), bytes.size() - to), block);
  }
}

uint32_t big_endian(const std::string& bytes, size_t at) {
  uint32_t value = 0;
  for (size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
  return value;
}

void mend_png(std::string& bytes) {
  for (size_t at = 8; at + 12 <= bytes.size();) {
    const size_t length = big_endian(bytes, at);
    if (length > bytes.size() - at - 12) return;
    const uLong sum =
        crc32(0, reinterpret_cast<const Bytef*>(bytes.data() + at + 4), static_cast<uInt>(length + 4));
    for (size_t i = 0; i < 4; ++i) bytes[at + 8 + length + i] = static_cast<char>(sum >> (24 - 8 * i));
    at += length + 12;
  }
}

void mend_glb(std::string& bytes, const std::string& whole) {
  if (bytes.size() < 20 || bytes.size() + 100000 < whole.size()) return;
  const auto write = [&bytes](size_t at, uint32_t value) { std::memcpy(&bytes[at], &value, sizeof value); };
  uint32_t json = 0;
  std::memcpy(&json, &bytes[12], sizeof json);
  const size_t binary = bytes.find(std::string("BIN\0", 4));
  if (binary != std::string::npos && binary >= 24) json = static_cast<uint32_t>(binary - 24);
  write(8, static_cast<uint32_t>(bytes.size()));
  write(12, json);
  if (binary != std::string::npos && binary >= 24)
    write(binary - 4, static_cast<uint32_t>(bytes.size() - binary - 4));
}

bool is_text(const std::string& bytes) {
  return std::none_of(bytes.begin(), bytes.end(), [](char c) { return c == 0; });
}

}  // namespace

std::string mutated(const std::string& whole, std::mt19937& random) {
  std::string bytes = whole;
  const bool is_words = is_text(whole) || whole.compare(0, 4, "glTF") == 0;
  for (size_t changes = 1 + below(random, 1 + below(random, 4)); changes > 0 && !bytes.empty(); --changes) {
    switch (random() % 8) {
      case 0:
        write_number(bytes, random);
        break;
      case 1:
        move_block(bytes, random);
        break;
      case 2:
      case 3:
        is_words ? insert_word(bytes, random) : flip(bytes, random);
        break;
      case 4:
      case 5:
        is_words ? change_number(bytes, random) : write_number(bytes, random);
        break;
      default:
        flip(bytes, random);
    }
  }
  if (random() % 10 == 0) bytes.resize(below(random, bytes.size() + 1));
  if (random() % 2 && whole.compare(0, 4, "\x89PNG") == 0) mend_png(bytes);
  if (random() % 4 && whole.compare(0, 4, "glTF") == 0) mend_glb(bytes, whole);
  return bytes;
}

}  // namespace ohb
