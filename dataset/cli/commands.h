// The commands of openhumanbrdf. Each cmd_<name>.cpp adds its sub-command with its options and says what to
// run; main() parses, limits the threads and runs the one that was named.
#pragma once

#include <cstdint>
#include <functional>

namespace CLI {
class App;
}

namespace ohb {

/// Options that every command has; the seed is of those that draw random numbers.
struct CommonOptions {
  int threads = 0;  // 0: all cores
  uint64_t seed = 1;
  bool json = false;  // one machine-readable result on stdout; progress and logs go to stderr
};

struct Commands {
  CommonOptions common;
  std::function<int()> run;  // set by the sub-command's callback; returns the exit code

  /// Adds every command to the app.
  void add_to(CLI::App& app);
};

/// Adds --threads and --json.
void add_common_options(CLI::App& command, CommonOptions& options);
/// Adds --seed: for the commands that draw random numbers.
void add_seed_option(CLI::App& command, CommonOptions& options);

}  // namespace ohb
