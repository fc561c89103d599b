#include "dataset/program/commands.h"

#include "dataset/program/option_checks.h"

namespace ohb::program {

void add_common_options(CLI::App& command, CommonOptions& options) {
  command.add_option("--threads", options.threads, "threads to use (default: all processors)")
      ->check(whole_within(0, 4096));
  command.add_flag("--json", options.json, "print one machine-readable result on stdout");
}

void add_seed_option(CLI::App& command, CommonOptions& options, uint64_t highest_seed) {
  command.add_option("--seed", options.seed, "seed of the random numbers")
      ->check(whole_within(0, highest_seed))
      ->capture_default_str();
}

}  // namespace ohb::program
