// Reading MakeHuman's text files: whole, within limits, and with messages that name file, line and mend.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "dataset/model/text_lines.h"

namespace ohb::people {

/// The file's text; one that ends in .gz is inflated. Throws InputError if it is missing, not whole, or
/// larger than 256 MiB.
std::string read_asset_text(const std::filesystem::path& file);

/// The lines of an asset's text, with words that become numbers or errors.
class AssetLines {
 public:
  /// `text` must outlive this.
  AssetLines(const std::filesystem::path& file, std::string_view text) : file_(file), lines_(file, text) {}

  /// Moves to the next line that is not empty; false at the end.
  bool next();
  /// The line's next word; "" at its end.
  std::string_view word() { return next_word(rest_); }
  /// What is left of the line, blanks trimmed.
  std::string rest() const { return std::string(trimmed(rest_)); }
  bool is_at_end() const { return trimmed(rest_).empty(); }

  /// The next word as a finite number. Throws InputError, naming `what`.
  float number(const char* what);
  /// The next word as an index below `count`. Throws InputError, naming `what`.
  uint32_t index(const char* what, size_t count);
  /// Throws InputError: this line, what is wrong.
  [[noreturn]] void fail(const std::string& cause) const;

 private:
  std::filesystem::path file_;
  TextLines lines_;
  std::string_view rest_;
};

/// A path that an asset's file names, relative to it. Throws InputError if it leads outside `assets`, or
/// nowhere.
std::filesystem::path asset_path(const std::filesystem::path& assets, const std::filesystem::path& referrer,
                                 const std::string& name);

}  // namespace ohb::people
