#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "dataset/cli/commands.h"
#include "dataset/cli/version.h"
#include "dataset/model/error.h"
#include "dataset/model/image.h"
#include "dataset/model/interrupt.h"

namespace ohb {

namespace {

int run(int argc, char** argv) {
  CLI::App app{
      "Ground truth of human materials: label, bake, render, validate.\n"
      "Example: openhumanbrdf inspect person.obj",
      "openhumanbrdf"};
  app.require_subcommand(1);
  app.set_version_flag("--version", version_text);
  Commands commands;
  commands.add_to(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& information) {
    return app.exit(information);
  } catch (const CLI::RequiredError& error) {
    // CLI11 reports a misspelt command as a missing one.
    const bool misspelt = app.get_subcommands().empty() && argc > 1 && argv[1][0] != '-';
    const std::string words = misspelt ? std::string("there is no command '") + argv[1] + "'" : error.what();
    std::fprintf(stderr, "openhumanbrdf: %s; see openhumanbrdf --help\n", words.c_str());
    return kExitBadInput;
  } catch (const CLI::ParseError& error) {
    std::fprintf(stderr, "openhumanbrdf: %s; see openhumanbrdf --help\n", error.what());
    return kExitBadInput;
  }
  std::unique_ptr<tbb::global_control> limit;
  if (commands.common.threads > 0) {
    limit = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                  static_cast<size_t>(commands.common.threads));
    limit_image_threads(commands.common.threads);
  }
  check_processor();
  catch_interrupts();
  // stdout belongs to results.
  spdlog::set_default_logger(spdlog::stderr_color_mt("openhumanbrdf"));
  spdlog::set_pattern("%^%l%$: %v");
  return commands.run();
}

}  // namespace
}  // namespace ohb

int main(int argc, char** argv) {
  try {
    return ohb::run(argc, argv);
  } catch (const ohb::InputError& error) {
    std::fprintf(stderr, "openhumanbrdf: %s\n", error.what());
    return ohb::kExitBadInput;
  } catch (const ohb::TryAgainError& error) {
    std::fprintf(stderr, "openhumanbrdf: %s\n", error.what());
    return ohb::kExitTryAgain;
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "openhumanbrdf: not enough memory; use smaller maps or images\n");
    return ohb::kExitTryAgain;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "openhumanbrdf: a bug: %s; please report it with the command line\n", error.what());
    return ohb::kExitBug;
  }
}
