#include <CLI/CLI.hpp>
#include <cstdio>
#include <optional>

#include "dataset/model/atomic_file.h"
#include "dataset/model/atomic_folder.h"
#include "dataset/model/json_text.h"
#include "dataset/program/help.h"
#include "dataset/program/option_checks.h"
#include "learner/blas.h"
#include "learner/cli/commands.h"
#include "learner/device.h"
#include "learner/evaluate.h"

namespace ohb::learner {
namespace {

struct Arguments {
  learner::EvaluateOptions evaluate;
  std::vector<std::string> weights, environments;
  std::string data, output, device = "auto";
  bool no_relight = false;
};

std::vector<std::filesystem::path> inputs_of(const Arguments& arguments) {
  std::vector<std::filesystem::path> inputs(arguments.weights.begin(), arguments.weights.end());
  inputs.insert(inputs.end(), arguments.environments.begin(), arguments.environments.end());
  inputs.push_back(arguments.data);
  return inputs;
}

int run_evaluate(Arguments arguments, const CommonOptions& common) {
  learner::EvaluateOptions& o = arguments.evaluate;
  o.weights.assign(arguments.weights.begin(), arguments.weights.end());
  o.data = arguments.data;
  o.relit.environments.assign(arguments.environments.begin(), arguments.environments.end());
  if (arguments.no_relight) o.relit.views_a_person = 0;
  o.device = device_of(arguments.device);
  use_threads(common.threads);
  learner::warn_of_slow_blas();
  std::optional<AtomicFolder> folder;
  if (!arguments.output.empty()) folder.emplace(arguments.output, "evaluation", inputs_of(arguments));
  const learner::EvaluationReport report = learner::evaluate(o);
  const std::string json = json_text(learner::json_of(report), 2) + "\n", table = learner::table_of(report);
  if (folder) {
    write_file_atomically(folder->path() / "evaluation.json", json);
    write_file_atomically(folder->path() / "evaluation.md", table);
    folder->commit();
  }
  if (common.json) {
    std::printf("%s", json.c_str());
    return 0;
  }
  std::printf("%s", table.c_str());
  std::printf("%zu pictures of %zu people at %d x %d; %.3f s a picture\n", report.pictures,
              report.people.size(), report.size_px, report.size_px, report.seconds_a_picture);
  if (report.relit)
    std::printf("%zu pictures relit with %d paths a pixel; %.1f s a picture\n", report.relit->pictures,
                report.relit->spp, report.relit->seconds_a_picture);
  return 0;
}

}  // namespace

void add_evaluate_command(CLI::App& app, Commands& commands) {
  CLI::App* command =
      app.add_subcommand("evaluate", "PSNR of estimated maps on people that training held out");
  auto arguments = std::make_shared<Arguments>();
  command
      ->add_option("RUN", arguments->weights,
                   "runs or weights: joint, or geometry, albedo and rss or some of them; finetune or not")
      ->required();
  command->add_option("--data", arguments->data, "folder with a folder of views a person")->required();
  command->add_option(
      "--person", arguments->evaluate.people,
      "person to evaluate; may be repeated (default: those held out, and trained on by none)");
  command
      ->add_option("--size", arguments->evaluate.size_px,
                   "pixels of a side, a multiple of 16 (default: as trained)")
      ->check(program::whole_within(16, 8192));
  command
      ->add_option("--environment", arguments->environments,
                   "latitude-longitude map to relight by; may be repeated (default: our studio and sunset)")
      ->allow_extra_args(false);
  command
      ->add_option("--relight-views", arguments->evaluate.relit.views_a_person,
                   "views a person that are relit, evenly around the turn")
      ->check(program::whole_within(0, 1 << 20))
      ->capture_default_str();
  command->add_option("--relight-spp", arguments->evaluate.relit.spp, "paths a pixel of relit pictures")
      ->check(program::whole_within(1, 1 << 24))
      ->capture_default_str();
  add_device_option(*command, arguments->device);
  command->add_flag("--no-relight", arguments->no_relight, "leave relighting out");
  command->add_option("-o,--output", arguments->output, "folder for evaluation.json and evaluation.md");
  add_common_options(*command, commands.common);
  command->footer(program::help_footer(
      {"humanmaterial evaluate runs/geometry runs/albedo runs/rss --data dataset -o report",
       "humanmaterial evaluate runs/geometry runs/albedo runs/rss runs/finetune --data dataset "
       "--person ada --json"}));
  command->callback([arguments, &commands] {
    commands.run = [arguments, &commands] { return run_evaluate(*arguments, commands.common); };
  });
}

}  // namespace ohb::learner
