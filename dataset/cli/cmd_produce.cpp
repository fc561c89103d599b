#include <tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "dataset/cli/commands.h"
#include "dataset/model/error.h"
#include "dataset/model/json_text.h"
#include "dataset/production/dry_run.h"
#include "dataset/program/help.h"
#include "dataset/program/option_checks.h"

namespace ohb {
namespace {

struct Options {
  std::string plan;
  bool is_dry_run = false;
};

int threads_of_this_run() {
  return static_cast<int>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

int dry_run(const production::Plan& plan, const CommonOptions& common) {
  const production::Forecast forecast = production::forecast(plan, threads_of_this_run());
  std::printf("%s",
              common.json ? (json_text(to_json(forecast), 2) + "\n").c_str() : to_text(forecast).c_str());
  return 0;
}

}  // namespace

void add_produce_command(CLI::App& app, Commands& commands) {
  CLI::App* command =
      app.add_subcommand("produce", "A whole dataset from one plan: people, views, lights, splits");
  auto options = std::make_shared<Options>();
  command->add_option("PLAN", options->plan, "plan.xml: who, which views, which lights")->required();
  command
      ->add_flag("--dry-run", options->is_dry_run,
                 "checks the plan and says counts, disk and hours, from a set measured now")
      ->required();
  add_common_options(*command, commands.common);
  command->footer(program::help_footer({"openhumanbrdf produce plan.xml --dry-run"}));
  command->callback([options, &commands] {
    commands.run = [options, &commands] {
      return dry_run(production::read_plan(options->plan), commands.common);
    };
  });
}

}  // namespace ohb
