#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "dataset/cli/commands.h"
#include "dataset/model/json_text.h"
#include "dataset/production/slurm.h"
#include "dataset/program/help.h"
#include "dataset/program/option_checks.h"

namespace ohb {
namespace {

struct Options {
  production::SubmitJob job;
  std::string plan, output;
  bool is_dry_run = false;
};

int run_submit(const Options& options, const CommonOptions& common) {
  production::SubmitJob job = options.job;
  job.plan = production::read_plan(options.plan);
  job.output = options.output;
  job.threads = common.threads;
  const production::SubmitReport report =
      options.is_dry_run ? production::prepare(job) : production::submit(job);
  std::printf("%s", common.json ? (json_text(to_json(report), 2) + "\n").c_str()
                                : to_text(report, job.output).c_str());
  return 0;
}

}  // namespace

void add_submit_command(CLI::App& app, Commands& commands) {
  CLI::App* command = app.add_subcommand("submit", "Queues a production as a job array of a Slurm cluster");
  auto options = std::make_shared<Options>();
  command->add_option("PLAN", options->plan, "plan.xml: who, which views, which lights")->required();
  command->add_option("-o,--output", options->output, "folder of the dataset, which all nodes see")
      ->required();
  command->add_option("--tasks", options->job.tasks, "tasks of the array (default: one a person)")
      ->check(program::whole_within(1, 9999));
  command
      ->add_option("--at-once", options->job.at_once,
                   "tasks that run at the same time, at most (default: any)")
      ->check(program::whole_within(1, 9999));
  command->add_option(
      "--time", options->job.time,
      "time limit of a task, as 12:00:00 or 2-12 (default: the partition's); one that needs more is "
      "queued again");
  command->add_option("--partition", options->job.partition, "partition (default: the cluster's)");
  command
      ->add_option("--sbatch", options->job.sbatch,
                   "another option of sbatch: account=lab; may be given again")
      ->allow_extra_args(false);
  command->add_flag("--dry-run", options->is_dry_run, "prints the script, and queues and writes nothing");
  add_common_options(*command, commands.common);
  command->footer(
      program::help_footer({"openhumanbrdf submit plan.xml -o dataset --threads 16 --time 12:00:00",
                            "openhumanbrdf submit plan.xml -o dataset --partition cpu --sbatch account=lab "
                            "--sbatch mem-per-cpu=2G",
                            "openhumanbrdf submit plan.xml -o dataset --tasks 20 --dry-run"},
                           "--threads is the cores of each task (default: what the cluster gives). A task "
                           "makes its people one after the "
                           "other. `openhumanbrdf status dataset` says how far the array is; the same "
                           "command again makes what is missing."));
  command->callback([options, &commands] {
    commands.run = [options, &commands] { return run_submit(*options, commands.common); };
  });
}

}  // namespace ohb
