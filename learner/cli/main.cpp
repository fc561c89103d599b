#include <dlfcn.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <string_view>

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
  add_commands(app, commands);
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

/// OpenBLAS goes by a list of processors that it knows and falls back to SSE3 on newer ones, a third to a
/// fifth of the speed (0.3.21 of Debian 12 on a Xeon without AMX in a virtual machine). Its name for kernels
/// that this processor can run, or null if it has chosen well or another library is there.
const char* better_blas_kernels() {
  using CoreName = const char* (*)();
  const auto core_name = reinterpret_cast<CoreName>(::dlsym(RTLD_DEFAULT, "openblas_get_corename"));
  if (!core_name) return nullptr;
  const std::string chosen = core_name();
  for (const char* old : {"Prescott", "Core2", "Penryn", "Dunnington", "Nehalem", "Atom", "generic"})
    if (chosen == old) {
      if (__builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw") &&
          __builtin_cpu_supports("avx512vl"))
        return "SKYLAKEX";
      return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") ? "HASWELL" : nullptr;
    }
  return nullptr;
}

/// Whether the words are more than a look at the help, which is there sooner if the program starts once only.
/// relight leaves all that takes time to Blender.
bool needs_fast_libraries(int argc, char** argv) {
  if (argc < 2 || std::string_view(argv[1]) == "relight") return false;
  return std::none_of(argv + 1, argv + argc, [](const std::string_view word) {
    return word == "--help" || word == "-h" || word == "--version";
  });
}

/// What libraries read from the environment when they are loaded; the program starts itself once more with
/// it, before it catches signals, which starting again would let go. What is set already is left alone.
/// OpenMP's threads spin while they wait, which makes everything several times slower on a machine that
/// others use too.
void start_again_with_fast_libraries(char** argv) {
  bool changed = false;
  const auto set = [&](const char* name, const char* value) {
    if (!value || std::getenv(name)) return;
    ::setenv(name, value, 1);
    changed = true;
  };
  set("OMP_WAIT_POLICY", "passive");
  set("OPENBLAS_CORETYPE", better_blas_kernels());
  if (changed)
    ::execv("/proc/self/exe", argv);  // returns only if it fails, and then all goes on, just slower
}

}  // namespace
}  // namespace ohb::learner

int main(int argc, char** argv) {
  if (ohb::learner::needs_fast_libraries(argc, argv)) ohb::learner::start_again_with_fast_libraries(argv);
  return ohb::program::run_program("humanmaterial", "use a smaller --size, --width or --batch",
                                   [&] { return ohb::learner::run(argc, argv); });
}
