#include <CLI/CLI.hpp>
#include <cstdio>

#include "dataset/model/atomic_file.h"
#include "dataset/model/atomic_folder.h"
#include "dataset/model/json_text.h"
#include "dataset/program/help.h"
#include "dataset/program/option_checks.h"
#include "learner/blas.h"
#include "learner/cli/commands.h"
#include "learner/device.h"
#include "learner/stress.h"

namespace ohb::learner {
namespace {

struct Arguments {
  learner::StressOptions stress;
  std::vector<std::string> weights;
  std::string data, output, device = "auto";
};

int run(Arguments arguments, const CommonOptions& common) {
  learner::StressOptions& o = arguments.stress;
  o.weights.assign(arguments.weights.begin(), arguments.weights.end());
  o.data = arguments.data;
  o.seed = common.seed;
  o.device = device_of(arguments.device);
  use_threads(common.threads);
  learner::warn_of_slow_blas();
  std::vector<std::filesystem::path> inputs = o.weights;
  inputs.push_back(o.data);
  AtomicFolder folder(arguments.output, "chart of hard pictures", inputs);
  const learner::StressReport report = learner::run_stress(o);
  const std::string json = json_text(learner::stress_json(report), 2) + "\n";
  write_file_atomically(folder.path() / "stress.md", learner::stress_table(report));
  write_file_atomically(folder.path() / "chart.csv", learner::stress_csv(report));
  write_file_atomically(folder.path() / "chart.json", json);
  learner::draw_stress(report, folder.path());
  folder.commit();
  if (common.json)
    std::printf("%s", json.c_str());
  else
    std::printf("%s%s/chart.svg\n", learner::stress_table(report).c_str(), arguments.output.c_str());
  return 0;
}

}  // namespace

void add_stress_command(CLI::App& app, Commands& commands) {
  CLI::App* command = app.add_subcommand(
      "stress", "Where estimates break: hard light, noise, JPEG, wrong masks, crops, sizes");
  auto arguments = std::make_shared<Arguments>();
  command
      ->add_option("RUN", arguments->weights,
                   "runs or weights: joint, or geometry, albedo and rss; finetune or not")
      ->required();
  command->add_option("--data", arguments->data, "folder with a folder of views a person")->required();
  command->add_option("--person", arguments->stress.people,
                      "person to take; may be repeated (default: as evaluate)");
  command
      ->add_option("--size", arguments->stress.size_px,
                   "pixels of a side, a multiple of 16 (default: as trained)")
      ->check(program::whole_within(16, 8192));
  command->add_option("--views", arguments->stress.views_a_person, "views a person, evenly around the turn")
      ->check(program::whole_within(1, 1 << 20))
      ->capture_default_str();
  command->add_option("--spp", arguments->stress.spp, "paths a pixel of the pictures")
      ->check(program::whole_within(1, 1 << 24))
      ->capture_default_str();
  add_device_option(*command, arguments->device);
  command->add_option("-o,--output", arguments->output, "folder for the chart")->required();
  add_common_options(*command, commands.common);
  add_seed_option(*command, commands.common);
  command->footer(
      program::help_footer({"humanmaterial stress assets/weights/*.safetensors --data dataset -o stress"}));
  command->callback([arguments, &commands] {
    commands.run = [arguments, &commands] { return run(*arguments, commands.common); };
  });
}

}  // namespace ohb::learner
