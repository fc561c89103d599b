// What a program's commands hand to main(): each adds its sub-command with its options and says what to run;
// main() parses, and runs the one that was named.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <functional>

namespace ohb::program {

/// Options that every command has; the seed is of those that draw random numbers.
struct CommonOptions {
  int threads = 0;  // 0: all processors
  uint64_t seed = 1;
  bool json = false;  // one machine-readable result on stdout; progress and logs go to stderr
};

struct Commands {
  CommonOptions common;
  std::function<int()> run;  // set by the sub-command's callback; returns the exit code
};

/// Adds --threads and --json.
void add_common_options(CLI::App& command, CommonOptions& options);
/// Adds --seed, 0 to `highest_seed`: for the commands that draw random numbers.
void add_seed_option(CLI::App& command, CommonOptions& options, uint64_t highest_seed = UINT64_MAX);

}  // namespace ohb::program
