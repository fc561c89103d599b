#include <tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "dataset/cli/commands.h"
#include "dataset/model/error.h"
#include "dataset/model/json_text.h"
#include "dataset/production/dry_run.h"
#include "dataset/production/supervisor.h"
#include "dataset/production/worker.h"
#include "dataset/program/help.h"
#include "dataset/program/option_checks.h"

namespace ohb {
namespace {

struct Options {
  std::string plan, output, shard = "1/1", person;
  int workers = 1;
  double stall_s = production::ProduceJob().stall_s;
  bool is_dry_run = false;
};

int threads_of_this_run() {
  return static_cast<int>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

int dry_run(const production::Plan& plan, const CommonOptions& common) {
  const production::Forecast forecast = production::forecast(plan, threads_of_this_run());
  std::printf("%s",
              common.json ? (json_text(to_json(forecast), 2) + "\n").c_str() : to_text(forecast).c_str());
  return kExitDone;
}

int run_produce(const Options& options, const CommonOptions& common) {
  production::ProduceJob job;
  job.shard = production::parse_shard(options.shard);
  job.plan = production::read_plan(options.plan);
  if (options.is_dry_run) return dry_run(job.plan, common);
  if (options.output.empty())
    throw InputError("", "-o", "names no folder", "give the folder of the dataset, or --dry-run");
  if (!options.person.empty()) {
    production::produce_person(job.plan, job.plan.person(options.person), {options.output});
    return kExitDone;
  }
  job.output = options.output;
  job.workers = options.workers;
  job.threads = threads_of_this_run();
  job.stall_s = options.stall_s;
  job.quiet = common.json;
  const production::ProduceReport report = production::produce(job);
  std::printf("%s", common.json ? (json_text(to_json(report), 2) + "\n").c_str()
                                : to_text(report, job.output).c_str());
  if (!report.given_up.empty()) return kExitDifference;
  return report.busy.empty() ? kExitDone : kExitTryAgain;
}

}  // namespace

void add_produce_command(CLI::App& app, Commands& commands) {
  CLI::App* command =
      app.add_subcommand("produce", "A whole dataset from one plan: people, views, lights, splits");
  auto options = std::make_shared<Options>();
  command->add_option("PLAN", options->plan, "plan.xml: who, which views, which lights")->required();
  command->add_option("-o,--output", options->output, "folder of the dataset");
  command->add_flag("--dry-run", options->is_dry_run,
                    "checks the plan and says counts, disk and hours, from a set measured now");
  command->add_option("--workers", options->workers, "people made at once, one process each; share --threads")
      ->check(program::whole_within(1, 1024))
      ->capture_default_str();
  command
      ->add_option("--shard", options->shard, "i/n: the i-th of n parts of the people, for one of n machines")
      ->capture_default_str();
  command
      ->add_option("--stall", options->stall_s,
                   "seconds without a sign of life after which a worker is killed and tried again")
      ->check(program::number_within(1, 1e6))
      ->capture_default_str();
  // What the supervisor starts: the work of one person.
  command->add_option("--worker", options->person)->group("");
  add_common_options(*command, commands.common);
  command->footer(program::help_footer(
      {"openhumanbrdf produce plan.xml --dry-run", "openhumanbrdf produce plan.xml --workers 2 -o dataset",
       "openhumanbrdf produce plan.xml --shard 3/16 -o dataset"},
      "An interrupted run goes on where it stopped when the same command is given again; what a change of "
      "the "
      "plan or of an input does not touch is kept."));
  command->callback([options, &commands] {
    commands.run = [options, &commands] { return run_produce(*options, commands.common); };
  });
}

}  // namespace ohb
