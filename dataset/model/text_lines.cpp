#include "dataset/model/text_lines.h"

#include <charconv>
#include <cmath>

#include "dataset/model/error.h"

namespace ohb {
namespace {

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\v' || c == '\f';
}

std::string_view without_comment(std::string_view line) {
  return line.substr(0, line.find('#'));
}

bool starts_with(std::string_view text, std::string_view start) {
  return text.substr(0, start.size()) == start;
}

}  // namespace

TextLines::TextLines(const std::filesystem::path& file, std::string_view text) : rest_(text) {
  if (starts_with(text, "\xFF\xFE") || starts_with(text, "\xFE\xFF"))
    throw InputError(file.string(), "", "is UTF-16 text", "save it as UTF-8");
  if (starts_with(rest_, "\xEF\xBB\xBF")) rest_.remove_prefix(3);
  const size_t zero = text.find('\0');
  if (zero != std::string_view::npos)
    throw InputError(file.string(), "byte " + std::to_string(zero), "is binary data where text is expected",
                     "check that the file is complete and has the right ending");
}

std::string_view TextLines::take_physical_line() {
  const size_t end = rest_.find_first_of("\r\n");
  const std::string_view line = rest_.substr(0, end);
  if (end == std::string_view::npos) {
    rest_ = {};
  } else {
    rest_.remove_prefix(starts_with(rest_.substr(end), "\r\n") ? end + 2 : end + 1);
  }
  ++physical_lines_;
  return line;
}

bool TextLines::next() {
  if (rest_.empty()) return false;
  whole_line_ = trimmed(take_physical_line());
  line_ = trimmed(without_comment(whole_line_));
  number_ = physical_lines_;
  if (line_.empty() || line_.back() != '\\') return true;
  joined_.assign(line_.substr(0, line_.size() - 1));
  while (!rest_.empty()) {
    const std::string_view more = trimmed(without_comment(take_physical_line()));
    const bool goes_on = !more.empty() && more.back() == '\\';
    joined_ += ' ';
    joined_ += goes_on ? more.substr(0, more.size() - 1) : more;
    if (!goes_on) break;
  }
  line_ = whole_line_ = trimmed(joined_);
  return true;
}

std::string_view TextLines::name() const {
  std::string_view rest = whole_line_;
  next_word(rest);
  for (size_t i = 0; i < rest.size(); ++i)
    if (rest[i] == '#' && i > 0 && is_blank(rest[i - 1]) && (i + 1 == rest.size() || is_blank(rest[i + 1])))
      return trimmed(rest.substr(0, i));
  return trimmed(rest);
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

std::string_view next_word(std::string_view& line) {
  line = trimmed(line);
  size_t length = 0;
  while (length < line.size() && !is_blank(line[length])) ++length;
  const std::string_view word = line.substr(0, length);
  line.remove_prefix(length);
  return word;
}

bool parse_double(std::string_view word, double& value) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  const auto read = std::from_chars(word.data(), word.data() + word.size(), value);
  return read.ec == std::errc() && read.ptr == word.data() + word.size() && !word.empty();
}

bool parse_float(std::string_view word, float& value) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  const char* end = word.data() + word.size();
  const auto read = std::from_chars(word.data(), end, value);
  if (read.ptr != end || word.empty()) return false;
  if (read.ec == std::errc()) return true;
  // Out of range: too small is as good as 0, too large is an error.
  double wide = 0;
  if (!parse_double(word, wide) || std::abs(wide) > 1) return false;
  value = static_cast<float>(wide);
  return true;
}

bool parse_integer(std::string_view word, long long& value) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  const auto read = std::from_chars(word.data(), word.data() + word.size(), value);
  return read.ec == std::errc() && read.ptr == word.data() + word.size() && !word.empty();
}

}  // namespace ohb
