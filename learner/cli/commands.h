// The commands of humanmaterial. Each cmd_<name>.cpp adds its sub-command and says what to run.
#pragma once

#include <cstdint>
#include <functional>

namespace CLI {
class App;
}

namespace ohb::learner {

/// Options that every command has; the seed is of those that draw random numbers.
struct CommonOptions {
  int threads = 0;  // 0: all processors
  uint64_t seed = 1;
  bool json = false;  // one machine-readable result on stdout; progress and logs go to stderr
};

struct Commands {
  CommonOptions common;
  std::function<int()> run;  // set by the sub-command's callback; returns the exit code

  void add_to(CLI::App& app);
};

/// Adds --threads and --json.
void add_common_options(CLI::App& command, CommonOptions& options);
/// Adds --seed, 0 to `highest_seed`: for the commands that draw random numbers.
void add_seed_option(CLI::App& command, CommonOptions& options, uint64_t highest_seed = UINT64_MAX);

/// Sets the threads of libtorch and, where `threads` is above 0, of the path tracer (TBB); called once by
/// every command before it computes.
void use_threads(int threads);

}  // namespace ohb::learner
