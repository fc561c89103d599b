#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "dataset/cli/commands.h"
#include "dataset/model/error.h"
#include "dataset/model/json_text.h"
#include "dataset/production/verify.h"
#include "dataset/program/help.h"
#include "dataset/program/option_checks.h"

namespace ohb {
namespace {

int run_verify(production::VerifyJob job, const CommonOptions& common) {
  job.quiet = common.json;
  const production::VerifyReport report = production::verify_dataset(job);
  std::printf("%s", common.json ? (json_text(to_json(report), 2) + "\n").c_str() : to_text(report).c_str());
  return report.faults.empty() ? kExitDone : kExitDifference;
}

}  // namespace

void add_verify_command(CLI::App& app, Commands& commands) {
  CLI::App* command = app.add_subcommand("verify", "Is a dataset whole and right? A list of what is not");
  auto job = std::make_shared<production::VerifyJob>();
  command->add_option("DATASET", job->dataset, "folder that produce wrote")->required();
  command->add_option("--rerender", job->rerendered, "sets to render again and compare")
      ->check(program::whole_within(0, 100000))
      ->capture_default_str();
  command->add_option("--spp", job->spp, "paths a pixel of a set that is rendered again, twice")
      ->check(program::whole_within(1, 65536))
      ->capture_default_str();
  add_common_options(*command, commands.common);
  command->footer(program::help_footer(
      {"openhumanbrdf verify dataset", "openhumanbrdf verify dataset --rerender 20 --json"},
      "Exit code 1 if anything is wrong or missing."));
  command->callback(
      [job, &commands] { commands.run = [job, &commands] { return run_verify(*job, commands.common); }; });
}

}  // namespace ohb
