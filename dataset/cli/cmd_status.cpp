#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "dataset/cli/commands.h"
#include "dataset/model/interrupt.h"
#include "dataset/model/json_text.h"
#include "dataset/model/results.h"
#include "dataset/production/status.h"
#include "dataset/program/help.h"

namespace ohb {
namespace {

constexpr int kBetweenLooks = 20;  // tenths of a second
constexpr const char* kClear = "\033[H\033[2J";

int run_status(const std::string& dataset, bool watches, const CommonOptions& common) {
  for (;;) {
    const production::DatasetStatus status = production::status_of({dataset});
    if (watches && ::isatty(STDOUT_FILENO)) std::printf("%s", kClear);
    std::printf("%s", common.json ? (json_text(to_json(status), watches ? -1 : 2) + "\n").c_str()
                                  : to_text(status).c_str());
    if (!watches || status.sets == status.set_count) return 0;
    flush_results();
    for (int i = 0; i < kBetweenLooks; ++i) {
      throw_if_interrupted();
      ::usleep(100000);
    }
  }
}

}  // namespace

void add_status_command(CLI::App& app, Commands& commands) {
  CLI::App* command =
      app.add_subcommand("status", "How far a dataset is, what failed, how long it will take");
  auto dataset = std::make_shared<std::string>();
  auto watches = std::make_shared<bool>(false);
  command->add_option("DATASET", *dataset, "folder that produce writes")->required();
  command->add_flag("--watch", *watches, "look again every two seconds, until all sets are there");
  add_common_options(*command, commands.common);
  command->footer(
      program::help_footer({"openhumanbrdf status dataset", "openhumanbrdf status dataset --watch",
                            "openhumanbrdf status dataset --json"},
                           "Looks and changes nothing; produce may run meanwhile."));
  command->callback([dataset, watches, &commands] {
    commands.run = [dataset, watches, &commands] { return run_status(*dataset, *watches, commands.common); };
  });
}

}  // namespace ohb
