#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "dataset/cli/commands.h"
#include "dataset/model/atomic_file.h"
#include "dataset/model/atomic_folder.h"
#include "dataset/model/data_files.h"
#include "dataset/model/error.h"
#include "dataset/model/stopwatch.h"
#include "dataset/program/help.h"
#include "dataset/program/option_checks.h"
#include "dataset/studies/speed_accuracy.h"
#include "dataset/studies/stress.h"

namespace ohb {
namespace fs = std::filesystem;
namespace {

struct Options {
  std::string model, output;
  std::vector<std::string> environments;
  studies::SpeedAccuracySettings settings;
};

void print_summary(const studies::SpeedAccuracy& chart, const fs::path& output) {
  std::printf("%-28s %6s %9s %9s %9s  %s\n", "series", "spp", "load s", "wall s", "cpu s", "error");
  for (const studies::SpeedAccuracyPoint& p : chart.points)
    std::printf("%-28s %6d %9.2f %9.3f %9.3f  %.3f %%%s\n", p.series.c_str(), p.spp, p.load_s, p.wall_s,
                p.cpu_s, 100 * p.relative_error, p.on_front ? "  front" : "");
  for (const studies::SpeedAccuracyRatio& r : chart.ratios)
    std::printf("to an error of %.3f %%: %s%s takes %.2f times as long as %s (%.2f without loading)\n",
                100 * r.relative_error, r.cycles.c_str(),
                r.adaptive_threshold > 0 ? " with its adaptive stop" : "", r.with_loading, r.ours.c_str(),
                r.without_loading);
  if (chart.subsurface_effect > 0)
    std::printf("leaving subsurface out changes the picture by %.2f %% (root mean square over the subject)\n",
                100 * chart.subsurface_effect);
  std::printf("%s\n", (output / "chart.svg").c_str());
}

int run_chart(const Options& options, const CommonOptions& common) {
  studies::SpeedAccuracySettings settings = options.settings;
  settings.threads = common.threads;
  settings.seed = common.seed;
  Model model;
  std::vector<Environment> environments;
  for (int k = 0; k < 2; ++k) {  // the second time finds the files in memory, as Cycles does
    model = {}, environments.clear();
    const Stopwatch of_model;
    model = read_model(options.model, ModelParts::kForRendering);
    settings.model_read_s = of_model.wall_s();
    const Stopwatch of_environments;
    for (const std::string& file : options.environments) environments.push_back(read_environment(file));
    settings.environment_read_s = of_environments.wall_s() / static_cast<double>(environments.size());
  }
  std::vector<fs::path> inputs(options.environments.begin(), options.environments.end());
  inputs.push_back(options.model);
  AtomicFolder folder(options.output, "chart of speed and accuracy", inputs);
  const fs::path scratch = folder.path() / "scenes";
  fs::create_directories(scratch);
  const studies::SpeedAccuracy chart =
      studies::measure_speed_accuracy(model, environments, settings, scratch);
  fs::remove_all(scratch);
  write_file_atomically(folder.path() / "chart.csv", studies::speed_accuracy_csv(chart));
  write_file_atomically(folder.path() / "chart.json", studies::speed_accuracy_json(chart));
  studies::draw_speed_accuracy(chart, folder.path());
  folder.commit();
  if (common.json)
    std::printf("%s", studies::speed_accuracy_json(chart).c_str());
  else
    print_summary(chart, options.output);
  return 0;
}

struct StressOptions {
  std::string catalogue, output;
  studies::StressSettings settings;
  bool without_cycles = false, without_heavy = false;
};

int run_stress_chart(const StressOptions& options, const CommonOptions& common) {
  studies::StressSettings settings = options.settings;
  settings.threads = common.threads;
  settings.seed = common.seed;
  settings.with_cycles = !options.without_cycles;
  settings.with_heavy = !options.without_heavy;
  const fs::path file =
      options.catalogue.empty() ? program_file("assets/stress/catalogue.json") : fs::path(options.catalogue);
  const std::vector<studies::StressCase> catalogue = studies::read_stress_catalogue(file);
  AtomicFolder folder(options.output, "chart of hard cases", {file});
  const fs::path scratch = folder.path() / "scenes";
  const std::vector<studies::StressCaseResult> results = studies::run_stress(catalogue, settings, scratch);
  fs::remove_all(scratch);
  write_file_atomically(folder.path() / "chart.csv", studies::stress_csv(results));
  write_file_atomically(folder.path() / "chart.json", studies::stress_json(results));
  studies::draw_stress(results, folder.path());
  folder.commit();
  if (common.json)
    std::printf("%s", studies::stress_json(results).c_str());
  else
    studies::print_hard_cases(results, fs::path(options.output) / "chart.svg");
  for (const studies::StressCaseResult& c : results)
    if (!c.passes()) return kExitDifference;
  return 0;
}

void add_stress_chart(CLI::App& chart, Commands& commands) {
  CLI::App* command =
      chart.add_subcommand("stress", "Hard cases, from harmless to impossible: ours beside Cycles");
  auto options = std::make_shared<StressOptions>();
  studies::StressSettings& settings = options->settings;
  command->add_option("--catalogue", options->catalogue,
                      "cases and their limits (default: assets/stress/catalogue.json)");
  command->add_option("--case", settings.only, "this case alone, by its name");
  command->add_flag("--no-cycles", options->without_cycles, "ours alone; needs no Blender");
  command->add_flag("--no-heavy", options->without_heavy, "leaves out what takes gigabytes");
  command->add_option("--blender", settings.blender, "Blender 3.4 (default: blender in PATH)");
  command->add_option("--size", settings.size_px, "width and height in pixels")
      ->check(program::whole_within(8, 1024))
      ->capture_default_str();
  command->add_option("--spp", settings.spp, "paths a pixel")
      ->check(program::whole_within(1, 8192))
      ->capture_default_str();
  command->add_option("--seeds", settings.seeds, "images of each kind, whose spread is the noise")
      ->check(program::whole_within(2, 256))
      ->capture_default_str();
  command->add_option("-o,--output", options->output, "folder for chart.svg, .png, .csv and .json")
      ->required();
  add_common_options(*command, commands.common);
  add_seed_option(*command, commands.common);
  command->footer(
      program::help_footer({"openhumanbrdf chart stress -o stress",
                            "openhumanbrdf chart stress --case roughness --no-cycles -o stress"},
                           "Exit code 1: a case is not within the limits that the catalogue states."));
  command->callback([options, &commands] {
    commands.run = [options, &commands] { return run_stress_chart(*options, commands.common); };
  });
}

void add_speed_chart(CLI::App& chart, Commands& commands) {
  CLI::App* command = chart.add_subcommand("speed-accuracy", "Ours beside Cycles on one view of a model");
  auto options = std::make_shared<Options>();
  studies::SpeedAccuracySettings& settings = options->settings;
  command->add_option("MODEL", options->model, "folder that bake wrote")->required();
  command
      ->add_option(
          "--environment", options->environments,
          "latitude-longitude map, linear; with more than one, all lights in one pass are charted too")
      ->required();
  command->add_option("--blender", settings.blender, "Blender 3.4 (default: blender in PATH)");
  command->add_option("--size", settings.size_px, "width and height in pixels")
      ->check(program::whole_within(8, 8192))
      ->capture_default_str();
  command
      ->add_option("--max-spp", settings.max_spp,
                   "paths a pixel of the best images; the others take 4, 16, ...")
      ->check(program::whole_within(4, 8192))
      ->capture_default_str();
  command->add_option("--seeds", settings.seeds, "images of each kind, whose spread is the error")
      ->check(program::whole_within(2, 256))
      ->capture_default_str();
  command->add_option("--bounces", settings.max_bounces, "indirect bounces at most")
      ->check(program::whole_within(0, 1024))
      ->capture_default_str();
  command->add_option("-o,--output", options->output, "folder for chart.svg, .png, .csv and .json")
      ->required();
  add_common_options(*command, commands.common);
  add_seed_option(*command, commands.common);
  command->footer(
      program::help_footer({"openhumanbrdf chart speed-accuracy model --environment studio.exr -o chart",
                            "openhumanbrdf chart speed-accuracy model --environment a.exr --environment "
                            "b.exr --max-spp 64 -o chart"},
                           "Times mean something on an idle machine only."));
  command->callback([options, &commands] {
    commands.run = [options, &commands] { return run_chart(*options, commands.common); };
  });
}

}  // namespace

void add_bake_chart(CLI::App& chart, Commands& commands);         // cmd_chart_bake.cpp
void add_bake_stress_chart(CLI::App& chart, Commands& commands);  // cmd_chart_bake_stress.cpp

void add_chart_command(CLI::App& app, Commands& commands) {
  CLI::App* chart = app.add_subcommand("chart", "Charts of error against time, and of hard cases");
  chart->require_subcommand(1);
  chart->footer(
      program::help_footer({"openhumanbrdf chart speed-accuracy --help",
                            "openhumanbrdf chart speed-accuracy model --environment studio.exr -o chart"}));
  add_stress_chart(*chart, commands);
  add_bake_chart(*chart, commands);
  add_bake_stress_chart(*chart, commands);
  add_speed_chart(*chart, commands);
}

}  // namespace ohb
