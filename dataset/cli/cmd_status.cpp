#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "dataset/cli/commands.h"
#include "dataset/model/interrupt.h"
#include "dataset/model/json_text.h"
#include "dataset/model/results.h"
#include "dataset/model/stopwatch.h"
#include "dataset/production/slurm_array.h"
#include "dataset/production/status.h"
#include "dataset/program/help.h"

namespace ohb {
namespace {

constexpr int kBetweenLooks = 20;   // tenths of a second
constexpr double kAskSlurm_s = 30;  // clusters ask people not to ask more often
constexpr const char* kClear = "\033[H\033[2J";

/// What Slurm last said about the dataset's job array.
class SlurmLook {
 public:
  explicit SlurmLook(const production::Layout& layout) : layout_(layout) {}
  const std::optional<production::ArrayStatus>& at_most_every_half_minute() {
    if (!watch_ || watch_->wall_s() > kAskSlurm_s) {
      array_ = production::array_status(layout_);
      watch_.emplace();
    }
    return array_;
  }

 private:
  production::Layout layout_;
  std::optional<Stopwatch> watch_;
  std::optional<production::ArrayStatus> array_;
};

void print_status(const production::DatasetStatus& status,
                  const std::optional<production::ArrayStatus>& array, bool is_json, int indent) {
  if (is_json) {
    nlohmann::ordered_json json = to_json(status);
    if (array) json["array"] = to_json(*array);
    std::printf("%s\n", json_text(json, indent).c_str());
    return;
  }
  std::printf("%s%s", to_text(status).c_str(), array ? to_text(*array).c_str() : "");
}

int run_status(const std::string& dataset, bool watches, const CommonOptions& common) {
  SlurmLook slurm({dataset});
  for (;;) {
    const production::DatasetStatus status = production::status_of({dataset});
    const auto& array = slurm.at_most_every_half_minute();
    if (watches && ::isatty(STDOUT_FILENO)) std::printf("%s", kClear);
    print_status(status, array, common.json, watches ? -1 : 2);
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
