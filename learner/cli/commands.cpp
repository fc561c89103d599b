#include "learner/cli/commands.h"

#include <tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <thread>

#include "dataset/program/option_checks.h"
#include "learner/torch.h"

namespace ohb::learner {

void add_common_options(CLI::App& command, CommonOptions& options) {
  command.add_option("--threads", options.threads, "threads to use (default: all processors)")
      ->check(program::whole_within(0, 4096));
  command.add_flag("--json", options.json, "print one machine-readable result on stdout");
}

void add_seed_option(CLI::App& command, CommonOptions& options, uint64_t highest_seed) {
  command.add_option("--seed", options.seed, "seed of the random numbers")
      ->check(program::whole_within(0, highest_seed))
      ->capture_default_str();
}

void use_threads(int threads) {
  // libtorch would count the cores, not the processors, and take one thread on a machine of two.
  torch::set_num_threads(threads > 0 ? threads
                                     : static_cast<int>(std::max(1u, std::thread::hardware_concurrency())));
  if (threads <= 0) return;
  // Until the end of the process, which is the command's.
  static auto* const limit = new tbb::global_control(tbb::global_control::max_allowed_parallelism, threads);
  static_cast<void>(limit);
}

// Each of these is in its own cmd_<name>.cpp.
void add_train_command(CLI::App& app, Commands& commands);
void add_evaluate_command(CLI::App& app, Commands& commands);
void add_stress_command(CLI::App& app, Commands& commands);
void add_estimate_command(CLI::App& app, Commands& commands);
void add_relight_command(CLI::App& app, Commands& commands);
void add_torchscript_command(CLI::App& app, Commands& commands);

void Commands::add_to(CLI::App& app) {
  add_train_command(app, *this);
  add_evaluate_command(app, *this);
  add_stress_command(app, *this);
  add_estimate_command(app, *this);
  add_relight_command(app, *this);
  add_torchscript_command(app, *this);
}

}  // namespace ohb::learner
