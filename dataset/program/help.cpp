#include "dataset/program/help.h"

#include <sstream>

namespace ohb::program {
namespace {

constexpr size_t kTextColumn = 28;

std::string indented(const std::vector<std::string>& lines, size_t columns) {
  std::string text;
  for (const std::string& line : lines) text += std::string(columns, ' ') + line + "\n";
  return text;
}

/// `name` at the left, `text` at kTextColumn: beside it where there is room, else below.
std::string entry(const std::string& name, const std::string& text) {
  std::string left = indented(wrapped(name, kHelpWidth - 2), 2);
  if (text.empty()) return left;
  std::string right = indented(wrapped(text, kHelpWidth - kTextColumn), kTextColumn);
  if (name.size() + 4 > kTextColumn) return left + right;
  left.pop_back();
  return left + right.substr(left.size());
}

/// An option with its value, or the words before the first option.
std::vector<std::string> groups_of(const std::string& command) {
  std::vector<std::string> groups;
  std::istringstream words(command);
  for (std::string word; words >> word;)
    if (groups.empty() || word[0] == '-')
      groups.push_back(word);
    else
      groups.back() += " " + word;
  return groups;
}

/// A command over several lines, as a shell reads it; an option stays with its value.
std::string pasteable(const std::string& command) {
  constexpr size_t kEnd = 2;  // of a line that goes on: " \\"
  std::string text, line = " ";
  for (const std::string& group : groups_of(command)) {
    if (line.size() + 1 + group.size() + kEnd > kHelpWidth) {
      text += line + " \\\n";
      line = "     ";
    }
    line += " " + group;
  }
  return text + line + "\n";
}

}  // namespace

std::vector<std::string> wrapped(const std::string& text, size_t width) {
  std::vector<std::string> lines;
  std::istringstream paragraphs(text);
  for (std::string paragraph; std::getline(paragraphs, paragraph);) {
    std::istringstream words(paragraph);
    lines.emplace_back();
    for (std::string word; words >> word;) {
      if (!lines.back().empty() && lines.back().size() + 1 + word.size() > width) lines.emplace_back();
      lines.back() += (lines.back().empty() ? "" : " ") + word;
    }
  }
  return lines;
}

std::string HelpFormatter::make_usage(const CLI::App* app, std::string name) const {
  const std::vector<std::string> lines = wrapped(Formatter::make_usage(app, name), kHelpWidth - 7);
  std::string text = lines.front() + "\n";
  for (size_t i = 1; i < lines.size(); ++i) text += "       " + lines[i] + "\n";
  return text;
}

std::string HelpFormatter::make_description(const CLI::App* app) const {
  return indented(wrapped(app->get_description(), kHelpWidth), 0);
}

std::string HelpFormatter::make_option(const CLI::Option* option, bool is_positional) const {
  return entry(make_option_name(option, is_positional) + make_option_opts(option), make_option_desc(option));
}

std::string HelpFormatter::make_subcommand(const CLI::App* command) const {
  return entry(command->get_name(), command->get_description());
}

std::string help_footer(const std::vector<std::string>& commands, const std::string& notes) {
  std::string text = "Examples:\n";
  for (const std::string& command : commands) text += pasteable(command);
  text += indented(wrapped(notes, kHelpWidth), 0);
  text.pop_back();
  return text;
}

}  // namespace ohb::program
