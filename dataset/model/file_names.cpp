#include "dataset/model/file_names.h"

#include <iconv.h>
#include <utf8proc.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <optional>

#include "dataset/model/text_lines.h"

namespace ohb {
namespace {

constexpr size_t kLongestName = 1024;  // bytes; no file system has longer ones

bool is_ascii(std::string_view name) {
  return std::all_of(name.begin(), name.end(), [](char c) { return static_cast<unsigned char>(c) < 0x80; });
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

/// Nothing if the bytes are not of that encoding.
std::optional<std::string> as_utf8(std::string_view bytes, const char* encoding) {
  iconv_t converter = iconv_open("UTF-8", encoding);
  if (converter == reinterpret_cast<iconv_t>(-1)) return std::nullopt;
  std::string from(bytes), text(bytes.size() * 4 + 4, '\0');
  char *in = from.data(), *out = text.data();
  size_t in_left = from.size(), out_left = text.size();
  const bool is_whole = iconv(converter, &in, &in_left, &out, &out_left) != static_cast<size_t>(-1);
  iconv_close(converter);
  if (!is_whole || in_left > 0) return std::nullopt;
  text.resize(text.size() - out_left);
  return text;
}

/// Nothing if it is no UTF-8.
std::optional<std::string> folded(std::string_view utf8) {
  utf8proc_uint8_t* result = nullptr;
  const auto options = static_cast<utf8proc_option_t>(UTF8PROC_STABLE | UTF8PROC_COMPOSE | UTF8PROC_COMPAT |
                                                      UTF8PROC_CASEFOLD | UTF8PROC_IGNORE);
  const utf8proc_ssize_t length = utf8proc_map(reinterpret_cast<const utf8proc_uint8_t*>(utf8.data()),
                                               static_cast<utf8proc_ssize_t>(utf8.size()), &result, options);
  const std::unique_ptr<utf8proc_uint8_t, decltype(&std::free)> owned(result, &std::free);
  if (length < 0) return std::nullopt;
  return std::string(trimmed({reinterpret_cast<const char*>(result), static_cast<size_t>(length)}));
}

}  // namespace

std::string without_percent_escapes(std::string_view name) {
  std::string text;
  for (size_t i = 0; i < name.size(); ++i) {
    const bool is_escape =
        name[i] == '%' && i + 2 < name.size() && hex_digit(name[i + 1]) >= 0 && hex_digit(name[i + 2]) >= 0;
    text += is_escape ? static_cast<char>(hex_digit(name[i + 1]) * 16 + hex_digit(name[i + 2])) : name[i];
    if (is_escape) i += 2;
  }
  return text;
}

std::vector<std::string> name_readings(std::string_view name) {
  const std::string plain = without_percent_escapes(name.substr(0, kLongestName));
  std::vector<std::string> readings;
  const auto add = [&readings](const std::optional<std::string>& reading) {
    if (reading && std::find(readings.begin(), readings.end(), *reading) == readings.end())
      readings.push_back(*reading);
  };
  add(folded(plain));
  if (is_ascii(plain)) return readings;
  for (const char* encoding :
       {"WINDOWS-1252", "GB18030", "SHIFT_JIS", "EUC-KR", "CP437", "CP850", "MACINTOSH"})
    if (const std::optional<std::string> utf8 = as_utf8(plain, encoding)) add(folded(*utf8));
  return readings;
}

bool share_a_reading(const std::vector<std::string>& a, const std::vector<std::string>& b) {
  return std::find_first_of(a.begin(), a.end(), b.begin(), b.end()) != a.end();
}

std::string readable_name(std::string_view name) {
  if (is_ascii(name) || as_utf8(name, "UTF-8")) return std::string(name);
  std::string text;
  for (char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80) {
      text += c;
    } else {  // as Latin-1
      text += static_cast<char>(0xC0 | byte >> 6);
      text += static_cast<char>(0x80 | (byte & 0x3F));
    }
  }
  return text;
}

size_t name_distance(std::string_view a, std::string_view b) {
  a = a.substr(0, kLongestName);
  b = b.substr(0, kLongestName);
  std::vector<size_t> row(b.size() + 1);
  for (size_t j = 0; j < row.size(); ++j) row[j] = j;
  for (size_t i = 0; i < a.size(); ++i) {
    size_t diagonal = row[0];
    row[0] = i + 1;
    for (size_t j = 0; j < b.size(); ++j) {
      const size_t exchanged = diagonal + (a[i] != b[j]);
      diagonal = row[j + 1];
      row[j + 1] = std::min({row[j] + 1, row[j + 1] + 1, exchanged});
    }
  }
  return row.back();
}

}  // namespace ohb
