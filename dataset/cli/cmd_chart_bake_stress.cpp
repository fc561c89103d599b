#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "dataset/cli/commands.h"
#include "dataset/model/atomic_file.h"
#include "dataset/model/atomic_folder.h"
#include "dataset/model/data_files.h"
#include "dataset/model/error.h"
#include "dataset/program/help.h"
#include "dataset/studies/bake_stress.h"

namespace ohb {
namespace fs = std::filesystem;
namespace {

struct Options {
  std::string catalogue, only, output;
};

int run_stress_bake(const Options& options, const CommonOptions& common) {
  const fs::path file = options.catalogue.empty() ? program_file("assets/stress/bake_catalogue.json")
                                                  : fs::path(options.catalogue);
  const std::vector<studies::BakeStressCase> catalogue = studies::read_bake_stress_catalogue(file);
  AtomicFolder folder(options.output, "chart of hard bakes", {file});
  const fs::path scratch = folder.path() / "pictures";
  fs::create_directories(scratch);
  const std::vector<studies::BakeStressCaseResult> results =
      studies::run_bake_stress(catalogue, options.only, scratch);
  fs::remove_all(scratch);
  write_file_atomically(folder.path() / "chart.csv", studies::bake_stress_csv(results));
  write_file_atomically(folder.path() / "chart.json", studies::bake_stress_json(results));
  studies::draw_bake_stress(results, folder.path());
  folder.commit();
  if (common.json)
    std::printf("%s", studies::bake_stress_json(results).c_str());
  else
    studies::print_hard_cases(results, fs::path(options.output) / "chart.svg");
  for (const studies::BakeStressCaseResult& c : results)
    if (!c.passes()) return kExitDifference;
  return kExitDone;
}

}  // namespace

void add_bake_stress_chart(CLI::App& chart, Commands& commands) {
  CLI::App* command = chart.add_subcommand("bake-stress", "Bad unwraps, meshes and sources for bake");
  auto options = std::make_shared<Options>();
  command->add_option("--catalogue", options->catalogue,
                      "cases and their limits (default: assets/stress/bake_catalogue.json)");
  command->add_option("--case", options->only, "this case alone, by its name");
  command->add_option("-o,--output", options->output, "folder for chart.svg, .png, .csv and .json")
      ->required();
  add_common_options(*command, commands.common);
  command->footer(
      program::help_footer({"openhumanbrdf chart bake-stress -o stress",
                            "openhumanbrdf chart bake-stress --case \"sliver charts\" -o stress"},
                           "Exit code 1: a case is not within the limits that the catalogue states."));
  command->callback([options, &commands] {
    commands.run = [options, &commands] { return run_stress_bake(*options, commands.common); };
  });
}

}  // namespace ohb
