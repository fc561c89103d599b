#include "dataset/program/command_line.h"

#include <algorithm>
#include <cstdio>

#include "dataset/model/error.h"
#include "dataset/program/help.h"

namespace ohb::program {
namespace {

/// Letters to insert, leave out, replace, or exchange with a neighbour.
size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::vector<size_t>> d(a.size() + 1, std::vector<size_t>(b.size() + 1));
  for (size_t i = 0; i <= a.size(); ++i)
    for (size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        d[i][j] = i + j;
        continue;
      }
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  return d[a.size()][b.size()];
}

const CLI::App& deepest(const CLI::App& app) {
  const CLI::App* command = &app;
  while (!command->get_subcommands().empty()) command = command->get_subcommands().front();
  return *command;
}

std::vector<std::string> names_of_commands(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(command->get_name());
  return names;
}

std::vector<std::string> names_of_options(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

std::string unknown(const std::string& kind, const std::string& word, const std::vector<std::string>& names) {
  const std::optional<std::string> meant = nearest_name(word, names);
  return "there is no " + kind + " '" + word + "'" + (meant ? "; did you mean '" + *meant + "'?" : "");
}

/// What is said of an option that takes one value and was given several, or "".
std::string given_again(const CLI::App& command) {
  for (const CLI::Option* option : command.get_options())
    if (option->get_items_expected_max() == 1 && option->results().size() > 1)
      return option->get_name() + " is given " + std::to_string(option->results().size()) +
             " times: give it once";
  return "";
}

/// CLI11 reports a misspelt command or option as a missing one, if something required is missing with it.
std::string words_of(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App& command = deepest(app);
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr && !given_again(command).empty())
    return given_again(command);
  const std::vector<std::string> left = command.remaining();
  const auto option = std::find_if(left.begin(), left.end(),
                                   [](const std::string& word) { return word.size() > 1 && word[0] == '-'; });
  const bool is_about_these = dynamic_cast<const CLI::RequiredError*>(&error) != nullptr ||
                              dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr;
  if (!is_about_these || left.empty()) return error.what();
  if (!names_of_commands(command).empty() && left.front()[0] != '-')
    return unknown("command", left.front(), names_of_commands(command));
  if (option != left.end())
    return unknown("option", option->substr(0, option->find('=')), names_of_options(command));
  return error.what();
}

/// The name of an option or argument that was given nothing, as an unset variable of a shell gives it, or "".
std::string given_nothing(const CLI::App& command) {
  for (const CLI::Option* option : command.get_options()) {
    const std::vector<std::string>& values = option->results();
    if (std::find(values.begin(), values.end(), "") != values.end()) return option->get_name();
  }
  return "";
}

int refuse(const CLI::App& app, const std::string& words) {
  std::string path = app.get_name();
  for (const CLI::App* command = &app; !command->get_subcommands().empty();) {
    command = command->get_subcommands().front();
    path += " " + command->get_name();
  }
  std::fprintf(stderr, "%s: %s%s %s --help\n", app.get_name().c_str(), words.c_str(),
               words.back() == '?' ? " See" : "; see", path.c_str());
  return kExitBadInput;
}

}  // namespace

std::optional<int> parse_command_line(CLI::App& app, int argc, char** argv) {
  try {
    app.parse(argc, argv);
    const std::string empty = given_nothing(deepest(app));
    if (!empty.empty()) return refuse(app, empty + " is empty: give it a value, or leave it out");
    return std::nullopt;
  } catch (const CLI::Success& information) {
    return app.exit(information);
  } catch (const CLI::ParseError& error) {
    return refuse(app, words_of(app, error));
  }
}

std::optional<std::string> nearest_name(const std::string& word, const std::vector<std::string>& names) {
  std::optional<std::string> best;
  size_t least = std::max<size_t>(1, std::min<size_t>(word.size(), 60) / 3) + 1;
  for (const std::string& name : names)
    if (word.size() < 100 && edit_distance(word, name) < least) {
      least = edit_distance(word, name);
      best = name;
    }
  if (best) return best;
  const auto begins = [&](const std::string& name) { return name.compare(0, word.size(), word) == 0; };
  if (std::count_if(names.begin(), names.end(), begins) == 1)
    best = *std::find_if(names.begin(), names.end(), begins);
  return best;
}

}  // namespace ohb::program
