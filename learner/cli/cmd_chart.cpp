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
#include "learner/network_chart.h"

namespace ohb::learner {
namespace {

struct Arguments {
  NetworkChartOptions chart;
  std::vector<std::string> sets;
  std::string data, output, device = "auto";
};

int run(Arguments arguments, const CommonOptions& common) {
  NetworkChartOptions& o = arguments.chart;
  o.sets.assign(arguments.sets.begin(), arguments.sets.end());
  o.data = arguments.data;
  o.device = device_of(arguments.device);
  use_threads(common.threads);
  warn_of_slow_blas();
  std::vector<std::filesystem::path> inputs = o.sets;
  inputs.push_back(o.data);
  AtomicFolder folder(arguments.output, "chart of networks", inputs);
  const NetworkChart chart = chart_networks(o);
  const std::string table = network_chart_table(chart), json = json_text(network_chart_json(chart), 2) + "\n";
  write_file_atomically(folder.path() / "chart.md", table);
  write_file_atomically(folder.path() / "chart.csv", network_chart_csv(chart));
  write_file_atomically(folder.path() / "chart.json", json);
  draw_network_chart(chart, folder.path());
  folder.commit();
  if (common.json)
    std::printf("%s", json.c_str());
  else
    std::printf("%s%s/chart.svg\n", table.c_str(), arguments.output.c_str());
  return 0;
}

}  // namespace

void add_chart_command(CLI::App& app, Commands& commands) {
  CLI::App* command = app.add_subcommand("chart", "Networks side by side: accuracy against time");
  auto arguments = std::make_shared<Arguments>();
  command->add_option("SET", arguments->sets, "weights file, run, or folder of these; several to compare")
      ->required();
  command->add_option("--data", arguments->data, "folder with a folder of views a person")->required();
  command->add_option("--person", arguments->chart.people,
                      "person to take; may be repeated (default: as evaluate)");
  command
      ->add_option("--size", arguments->chart.size_px,
                   "pixels of a side, a multiple of 16 (default: the largest trained)")
      ->check(program::whole_within(16, 8192));
  add_device_option(*command, arguments->device);
  command->add_option("-o,--output", arguments->output, "folder for the chart")->required();
  add_common_options(*command, commands.common);
  command->footer(
      program::help_footer({"humanmaterial chart assets/weights runs/joint --data dataset -o chart"}));
  command->callback([arguments, &commands] {
    commands.run = [arguments, &commands] { return run(*arguments, commands.common); };
  });
}

}  // namespace ohb::learner
