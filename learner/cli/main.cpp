#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdlib>

#include "dataset/model/image.h"
#include "dataset/model/results.h"
#include "dataset/program/command_line.h"
#include "dataset/program/ends.h"
#include "dataset/program/help.h"
#include "learner/cli/commands.h"
#include "learner/torch.h"

namespace ohb::learner {
namespace {

std::string version_text() {
  std::string features;
  if (__builtin_cpu_supports("avx2")) features += " AVX2";
  if (__builtin_cpu_supports("fma")) features += " FMA";
  if (__builtin_cpu_supports("avx512f")) features += " AVX-512";
  return "humanmaterial " OHB_VERSION "\nlibtorch " TORCH_VERSION "\nOpenImageIO " + image_library_version() +
         "\nprocessor features:" + features + "\n";
}

int run(int argc, char** argv) {
  CLI::App app{"Materials of people from one photograph: train, evaluate, estimate, relight.",
               "humanmaterial"};
  app.formatter(std::make_shared<program::HelpFormatter>());
  app.require_subcommand(1);
  app.set_version_flag("--version", version_text);
  Commands commands;
  commands.add_to(app);
  app.footer(program::help_footer({"humanmaterial train geometry --data dataset -o runs/geometry"},
                                  "Each command has its own help: humanmaterial train --help"));
  if (const std::optional<int> code = program::parse_command_line(app, argc, argv)) {
    flush_results();
    return *code;
  }
  // stdout belongs to results.
  spdlog::set_default_logger(spdlog::stderr_color_mt("humanmaterial"));
  spdlog::set_pattern("%^%l%$: %v");
  const int code = commands.run();
  flush_results();
  return code;
}

/// OpenMP's threads spin while they wait, which makes everything several times slower on a machine that
/// others use too. The library reads its setting when it is loaded, so the program starts itself once more
/// with it; OMP_WAIT_POLICY=active in the environment is left alone.
void wait_without_spinning(char** argv) {
  if (std::getenv("OMP_WAIT_POLICY")) return;
  ::setenv("OMP_WAIT_POLICY", "passive", 1);
  ::execv("/proc/self/exe", argv);  // returns only if it fails, and then all goes on, just slower
}

}  // namespace
}  // namespace ohb::learner

int main(int argc, char** argv) {
  ohb::learner::wait_without_spinning(argv);
  return ohb::program::run_program("humanmaterial", "use a smaller --size, --width or --batch",
                                   [&] { return ohb::learner::run(argc, argv); });
}
