#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "dataset/cli/commands.h"
#include "dataset/environments/import.h"
#include "dataset/environments/synthesise.h"
#include "dataset/model/json_text.h"
#include "dataset/program/help.h"
#include "dataset/program/option_checks.h"

namespace ohb {
namespace {

constexpr uint64_t kWidest_px = 16384;

/// The height is half of it.
CLI::Validator even() {
  return CLI::Validator(
      [](std::string& value) {
        return (value.back() - '0') % 2 == 0 ? std::string()
                                             : "'" + value + "' is odd: the height is half of it";
      },
      "");
}

int print_change(const std::filesystem::path& library, const environments::LibraryChange& change,
                 bool as_json) {
  if (as_json) {
    std::printf("%s\n", json_text(environments::to_json(change), 2).c_str());
    return 0;
  }
  size_t there = 0;
  for (const auto& item : change.items) there += item.was_there;
  std::printf("%s: %zu environments made, %zu were there, %.0f s\n", library.c_str(),
              change.items.size() - there, there, change.seconds);
  return 0;
}

int run_list(const std::filesystem::path& library, bool as_json) {
  const std::vector<environments::LibraryEntry> entries = environments::read_library(library);
  nlohmann::json listed = nlohmann::json::array();
  bool is_whole = true;
  if (!as_json)
    std::printf("%-32s %-9s %5s %9s %11s  %-10s %s\n", "id", "category", "width", "mean", "peak", "licence",
                "file");
  for (const environments::LibraryEntry& entry : entries) {
    const std::string damage = environments::damage_of(library, entry);
    is_whole = is_whole && damage.empty();
    listed.push_back(environments::to_json(entry));
    listed.back()["damage"] = damage;
    const std::array<double, 3>& mean = entry.light.mean;
    if (!as_json)
      std::printf("%-32s %-9s %5d %9.3f %11.1f  %-10s %s\n", entry.id.c_str(), entry.category.c_str(),
                  entry.width_px, 0.2126 * mean[0] + 0.7152 * mean[1] + 0.0722 * mean[2], entry.light.peak,
                  entry.licence.c_str(), damage.empty() ? "whole" : damage.c_str());
  }
  if (as_json) std::printf("%s\n", json_text(nlohmann::json{{"environments", listed}}, 2).c_str());
  return is_whole ? 0 : 1;
}

CLI::App* sub_command(CLI::App& parent, Commands& commands, const char* name, const char* what) {
  CLI::App* command = parent.add_subcommand(name, what);
  add_common_options(*command, commands.common);
  return command;
}

void add_import(CLI::App& parent, Commands& commands) {
  CLI::App* command = sub_command(parent, commands, "import", "Panoramas (EXR, HDR) as people have them");
  auto job = std::make_shared<environments::ImportJob>();
  command->add_option("files", job->files, "latitude-longitude panoramas, 2:1")->required();
  command->add_option("-o,--output", job->library, "folder of the library")->required();
  command
      ->add_option("--width", job->width_px,
                   "width in the library in px, even (default: as it is, at most 4096)")
      ->check(program::whole_within(2, kWidest_px))
      ->check(even());
  command->add_option("--licence", job->licence, "licence of the files, for example CC0-1.0");
  command->add_option("--source", job->source, "where the files are from");
  command->footer(program::help_footer(
      {"openhumanbrdf environments import *.hdr --licence CC0-1.0 --source polyhaven.com -o lights",
       "openhumanbrdf environments import street.exr --width 1024 --licence 'CC-BY-4.0, A. Author' -o "
       "lights"},
      "A file's own licence and source may stand beside it: street.exr.json, "
      "{\"licence\": \"CC0-1.0\", \"source\": \"...\"}."));
  command->callback([job, &commands] {
    commands.run = [job, &commands] {
      job->quiet = commands.common.json;
      return print_change(job->library, environments::import_environments(*job), commands.common.json);
    };
  });
}

void add_synthesise(CLI::App& parent, Commands& commands) {
  CLI::App* command = sub_command(parent, commands, "synthesise", "Skies, studios, coloured lamps, rooms");
  add_seed_option(*command, commands.common);
  auto job = std::make_shared<environments::SynthesisJob>();
  command->add_option("-o,--output", job->library, "folder of the library")->required();
  command->add_option("--count", job->count, "environments to make")
      ->check(program::whole_within(1, environments::kMostSynthesised))
      ->capture_default_str();
  command->add_option("--width", job->width_px, "width in px, even; half as high")
      ->check(program::whole_within(16, kWidest_px))
      ->check(even())
      ->capture_default_str();
  command->footer(
      program::help_footer({"openhumanbrdf environments synthesise --count 310 --seed 1 -o lights",
                            "openhumanbrdf environments synthesise --count 10 --width 512 -o lights"},
                           "Number k depends on seed, k and width alone."));
  command->callback([job, &commands] {
    commands.run = [job, &commands] {
      job->seed = commands.common.seed;
      job->quiet = commands.common.json;
      return print_change(job->library, environments::synthesise_environments(*job), commands.common.json);
    };
  });
}

void add_list(CLI::App& parent, Commands& commands) {
  CLI::App* command = sub_command(parent, commands, "list", "What a library holds, and whether it is whole");
  auto library = std::make_shared<std::string>();
  command->add_option("library", *library, "folder of the library")->required();
  command->footer(program::help_footer(
      {"openhumanbrdf environments list lights", "openhumanbrdf environments list lights --json"},
      "Exit code 1: a file is missing or was changed."));
  command->callback([library, &commands] {
    commands.run = [library, &commands] { return run_list(*library, commands.common.json); };
  });
}

}  // namespace

void add_environments_command(CLI::App& app, Commands& commands) {
  CLI::App* command = app.add_subcommand("environments", "A library of lights: import, synthesise, list");
  command->require_subcommand(1);
  add_import(*command, commands);
  add_synthesise(*command, commands);
  add_list(*command, commands);
  command->footer(program::help_footer(
      {"openhumanbrdf environments import *.hdr --licence CC0-1.0 -o lights",
       "openhumanbrdf environments synthesise --count 310 -o lights"},
      "Then: openhumanbrdf render MODEL --environment lights/envmaps/s1_0003_sunset.exr"));
}

}  // namespace ohb
