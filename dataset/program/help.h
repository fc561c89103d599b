// Help that fits a terminal of 80 columns, with examples that can be pasted.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace ohb::program {

constexpr size_t kHelpWidth = 80;

/// CLI11's layout, with every text wrapped.
class HelpFormatter : public CLI::Formatter {
 public:
  std::string make_usage(const CLI::App* app, std::string name) const override;
  std::string make_description(const CLI::App* app) const override;
  std::string make_option(const CLI::Option* option, bool is_positional) const override;
  std::string make_subcommand(const CLI::App* command) const override;
};

/// "Examples:" and each command; one that is too long goes on behind a backslash. `notes` follows, wrapped.
std::string help_footer(const std::vector<std::string>& commands, const std::string& notes = "");

/// Lines of at most `width` characters, broken at blanks; a line break in the text is kept.
std::vector<std::string> wrapped(const std::string& text, size_t width);

}  // namespace ohb::program
