// The command line of a program: parsed, or refused in one line that names what was probably meant.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

namespace ohb::program {

/// Parses into `app`, whose name is the program's. Nothing if a command is to be run; else the exit code:
/// help and version are printed (0), bad usage is one line on stderr (kExitBadInput).
std::optional<int> parse_command_line(CLI::App& app, int argc, char** argv);

/// The one of `names` that `word` most probably misspells, or nothing: at most a third of its letters
/// inserted, left out, replaced or exchanged with a neighbour (Damerau 1964), or the only one that begins
/// with it.
std::optional<std::string> nearest_name(const std::string& word, const std::vector<std::string>& names);

}  // namespace ohb::program
