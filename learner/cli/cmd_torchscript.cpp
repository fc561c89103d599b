#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "dataset/model/json_text.h"
#include "dataset/program/help.h"
#include "learner/cli/commands.h"
#include "learner/torchscript.h"

namespace ohb::learner {
namespace {

struct Arguments {
  std::vector<std::string> weights;
  std::string output;
};

int run_torchscript(const Arguments& arguments, const CommonOptions& common) {
  use_threads(common.threads);
  const Estimator estimator({arguments.weights.begin(), arguments.weights.end()});
  const ScriptReport report = write_torchscript(estimator, arguments.output);
  if (common.json) {
    const nlohmann::json json = {{"file", arguments.output},
                                 {"size_px", report.size_px},
                                 {"parameters", report.parameters},
                                 {"finetuned", estimator.has_finetune()}};
    std::printf("%s\n", json_text(json, 2).c_str());
    return 0;
  }
  const auto size_px = static_cast<long long>(report.size_px);
  std::printf("%s: pictures of %lld x %lld to their maps, %.1f million parameters, %s\n",
              arguments.output.c_str(), size_px, size_px, static_cast<double>(report.parameters) / 1e6,
              estimator.has_finetune() ? "finetuned" : "not finetuned");
  return 0;
}

}  // namespace

void add_torchscript_command(CLI::App& app, Commands& commands) {
  CLI::App* command = app.add_subcommand("torchscript", "The networks as one file for PyTorch");
  auto arguments = std::make_shared<Arguments>();
  command
      ->add_option("--weights", arguments->weights,
                   "runs or weights: joint, or geometry, albedo and rss; finetune or not")
      ->required();
  command->add_option("-o,--output", arguments->output, "TorchScript file, such as estimator.pt")->required();
  add_common_options(*command, commands.common);
  command->footer(
      program::help_footer({"humanmaterial torchscript --weights weights/*.safetensors -o estimator.pt",
                            "humanmaterial torchscript --weights runs/geometry runs/albedo runs/rss "
                            "runs/finetune -o estimator.pt"},
                           "In Python: maps = torch.jit.load(\"estimator.pt\")(picture, mask)"));
  command->callback([arguments, &commands] {
    commands.run = [arguments, &commands] { return run_torchscript(*arguments, commands.common); };
  });
}

}  // namespace ohb::learner
