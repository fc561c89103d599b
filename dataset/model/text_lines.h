// Lines and words of text formats (OBJ, MTL), with the line numbers that error messages need.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace ohb {

/// Walks through the lines of a text. Ends of line: LF, CR LF or CR. A UTF-8 byte-order mark is skipped;
/// a backslash at the end of a line joins it with the next one.
class TextLines {
 public:
  /// `text` must outlive this. Throws InputError (naming `file`) for UTF-16 and for binary data.
  TextLines(const std::filesystem::path& file, std::string_view text);

  /// Moves to the next line; false at the end.
  bool next();
  /// The line without its comment (#...), blanks trimmed at both ends.
  std::string_view line() const { return line_; }
  /// What follows the line's first word, for statements of names, which may hold a '#' ("Material #25"): a
  /// comment begins at a '#' between blanks only.
  std::string_view name() const;
  /// The whole of a line that holds a comment alone, with its '#'; empty for other lines.
  std::string_view comment() const { return line_.empty() ? whole_line_ : std::string_view(); }
  /// "line 12", of the first of joined lines.
  std::string place() const { return "line " + std::to_string(number_); }
  size_t number() const { return number_; }

 private:
  std::string_view take_physical_line();

  std::string_view rest_, line_, whole_line_;
  std::string joined_;
  size_t number_ = 0, physical_lines_ = 0;
};

/// Without blanks at both ends.
std::string_view trimmed(std::string_view text);
/// Cuts the next blank-separated word off the front of `line`; empty at the end.
std::string_view next_word(std::string_view& line);

/// The word as a float, rounded correctly, whatever the locale. False for anything else, trailing
/// characters included, and for values beyond the float range; "nan" and "inf" are read as such.
bool parse_float(std::string_view word, float& value);
bool parse_double(std::string_view word, double& value);
/// The word as a decimal integer; false for anything else.
bool parse_integer(std::string_view word, long long& value);

}  // namespace ohb
