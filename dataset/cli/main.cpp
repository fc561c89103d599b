#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "dataset/cli/commands.h"
#include "dataset/cli/version.h"
#include "dataset/model/image.h"
#include "dataset/model/results.h"
#include "dataset/program/command_line.h"
#include "dataset/program/ends.h"
#include "dataset/program/help.h"

namespace ohb {

namespace {

int run(int argc, char** argv) {
  CLI::App app{"Ground truth of human materials: label, bake, render, validate.", "openhumanbrdf"};
  app.formatter(std::make_shared<program::HelpFormatter>());
  app.require_subcommand(1);
  app.set_version_flag("--version", version_text);
  Commands commands;
  add_commands(app, commands);
  app.footer(program::help_footer({"openhumanbrdf inspect person.obj"},
                                  "Each command has its own help: openhumanbrdf label --help"));
  if (const std::optional<int> code = program::parse_command_line(app, argc, argv)) {
    flush_results();
    return *code;
  }
  std::unique_ptr<tbb::global_control> limit;
  if (commands.common.threads > 0) {
    limit = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                  static_cast<size_t>(commands.common.threads));
    limit_image_threads(commands.common.threads);
  }
  check_processor();
  // stdout belongs to results.
  spdlog::set_default_logger(spdlog::stderr_color_mt("openhumanbrdf"));
  spdlog::set_pattern("%^%l%$: %v");
  const int code = commands.run();
  flush_results();
  return code;
}

}  // namespace
}  // namespace ohb

int main(int argc, char** argv) {
  return ohb::program::run_program("openhumanbrdf", "use smaller maps or images",
                                   [&] { return ohb::run(argc, argv); });
}
