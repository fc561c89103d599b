#include "dataset/cli/commands.h"

#include <CLI/CLI.hpp>

#include "dataset/program/option_checks.h"

namespace ohb {

void add_common_options(CLI::App& command, CommonOptions& options) {
  command.add_option("--threads", options.threads, "threads to use (default: all cores)")
      ->check(program::whole_within(0, 4096));
  command.add_flag("--json", options.json, "print one machine-readable result on stdout");
}

void add_seed_option(CLI::App& command, CommonOptions& options) {
  command.add_option("--seed", options.seed, "seed of the random numbers")
      ->check(program::whole_within(0, UINT64_MAX))
      ->capture_default_str();
}

// Each of these is in its own cmd_<name>.cpp.
void add_inspect_command(CLI::App& app, Commands& commands);
void add_label_command(CLI::App& app, Commands& commands);
void add_bake_command(CLI::App& app, Commands& commands);
void add_render_command(CLI::App& app, Commands& commands);
void add_validate_command(CLI::App& app, Commands& commands);
void add_chart_command(CLI::App& app, Commands& commands);
void add_people_command(CLI::App& app, Commands& commands);
void add_produce_command(CLI::App& app, Commands& commands);
void add_submit_command(CLI::App& app, Commands& commands);
void add_status_command(CLI::App& app, Commands& commands);
void add_verify_command(CLI::App& app, Commands& commands);
void add_environments_command(CLI::App& app, Commands& commands);
void add_export_command(CLI::App& app, Commands& commands);

void Commands::add_to(CLI::App& app) {
  add_inspect_command(app, *this);
  add_label_command(app, *this);
  add_bake_command(app, *this);
  add_render_command(app, *this);
  add_validate_command(app, *this);
  add_chart_command(app, *this);
  add_people_command(app, *this);
  add_produce_command(app, *this);
  add_submit_command(app, *this);
  add_status_command(app, *this);
  add_verify_command(app, *this);
  add_environments_command(app, *this);
  add_export_command(app, *this);
}

}  // namespace ohb
