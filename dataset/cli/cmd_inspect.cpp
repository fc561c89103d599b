#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "dataset/cli/commands.h"
#include "dataset/commands/inspect.h"
#include "dataset/model/json_text.h"
#include "dataset/program/help.h"

namespace ohb {
namespace {

struct Options {
  std::string scan, unit, up;
};

int run_inspect(const Options& options, const CommonOptions& common) {
  std::optional<std::string> unit;
  if (!options.unit.empty()) unit = options.unit;
  Scan scan = read_scan(options.scan, MissingFiles::kReported);
  turn_up(scan, options.up);
  const commands::InspectReport report = commands::inspect_scan(scan, unit, !options.up.empty());
  const std::string text =
      common.json ? json_text(commands::inspect_json(report), 2) + "\n" : commands::inspect_text(report);
  std::fputs(text.c_str(), stdout);
  return 0;
}

}  // namespace

void add_inspect_command(CLI::App& app, Commands& commands) {
  CLI::App* command =
      app.add_subcommand("inspect", "What a scan is, and what is wrong with it and how to mend it");
  auto options = std::make_shared<Options>();
  command->add_option("SCAN", options->scan, ".obj, .glb, .gltf or .fbx")->required();
  command->add_option("--unit", options->unit, kUnitHelp);
  command->add_option("--up", options->up, kUpHelp);
  add_common_options(*command, commands.common);
  command->footer(program::help_footer(
      {"openhumanbrdf inspect person.obj", "openhumanbrdf inspect bust.glb --unit m --json"}));
  command->callback([options, &commands] {
    commands.run = [options, &commands] { return run_inspect(*options, commands.common); };
  });
}

}  // namespace ohb
