#include <CLI/CLI.hpp>
#include <cstdio>

#include "dataset/cli/commands.h"
#include "dataset/model/atomic_file.h"
#include "dataset/model/atomic_folder.h"
#include "dataset/model/error.h"
#include "dataset/program/help.h"
#include "dataset/program/option_checks.h"
#include "renderer/validation/report.h"

namespace ohb {
namespace fs = std::filesystem;
namespace {

struct Options {
  std::string model, environment, view = "0/1", subsurface = "walk", shading = "v1", output;
  bool install_bpy = false, keeps_scene = false;
  validation::ValidationSettings settings;
};

/// "k/n" with 0 <= k < n.
void parse_view(const std::string& text, validation::ValidationSettings& settings) {
  char rest;
  if (std::sscanf(text.c_str(), "%d/%d%c", &settings.view, &settings.view_count, &rest) != 2 ||
      settings.view < 0 || settings.view_count < 1 || settings.view >= settings.view_count)
    throw InputError("--view " + text, "", "is not k/n with 0 <= k < n", "write for example 25/100");
}

void print_summary(const validation::Validation& v, const fs::path& output) {
  std::printf("%-12s %9s  %s\n", "region", "pixels", "ours / Cycles - 1, 95 % interval");
  for (const auto& [region, work] : v.regions)
    std::printf("%-12s %9.0f  %+.3f %%  [%+.3f, %+.3f]  %d x %d paths, Cycles %d x %d\n", region.name.c_str(),
                region.weight_px, 100 * (region.total.value - 1), 100 * (region.total.low - 1),
                100 * (region.total.high - 1), work.seeds, work.our_spp, work.seeds, work.cycles_spp);
  std::printf("bins of 3 x 3 px accepted: %zu of %zu (%.2f %%); outline: %zu of %zu\n",
              v.inside_bins.accepted, v.inside_bins.bins, 100 * v.inside_bins.accepted_share,
              v.band_bins.accepted, v.band_bins.bins);
  const validation::SpeedRatio speed = validation::speed_at_equal_error(v);
  std::printf("an image: ours %.2f s, Cycles %.2f s; at equal error ours is %.2f times as fast\n",
              v.our_cost.wall_s, v.cycles_cost.wall_s, speed.wall);
  for (const std::string& reason : v.verdict.reasons) std::printf("%s\n", reason.c_str());
  std::printf("%s\n%s: %s\n", (output / "index.html").c_str(),
              v.verdict.outcome == validation::Outcome::kPass        ? "pass"
              : v.verdict.outcome == validation::Outcome::kUndecided ? "undecided"
                                                                     : "difference",
              v.verdict.sentence.c_str());
}

int run_validate(Options options, const CommonOptions& common) {
  validation::ValidationSettings& settings = options.settings;
  parse_view(options.view, settings);
  settings.threads = common.threads;
  settings.subsurface = options.subsurface == "walk";
  settings.shading = options.shading == "v2" ? renderer::ShadingModel::kV2 : renderer::ShadingModel::kV1;
  if (options.install_bpy) validation::install_bpy(settings.bpy);
  settings.seed = common.seed;
  const Model model = read_model(options.model, ModelParts::kForRendering);
  const Environment environment = read_environment(options.environment);
  AtomicFolder folder(options.output, "report of validate", {options.model, options.environment});
  const fs::path scratch = folder.path() / "scene";
  fs::create_directories(scratch);
  if (options.keeps_scene) settings.kept = folder.path() / "scene.blend";
  const validation::Validation validation = validation::validate(model, environment, settings, scratch);
  fs::remove_all(scratch);
  validation::write_validation(folder.path(), validation);
  folder.commit();
  if (common.json)
    std::printf("%s", validation::validation_json(validation).c_str());
  else
    print_summary(validation, options.output);
  switch (validation.verdict.outcome) {
    case validation::Outcome::kPass:
      return kExitDone;
    case validation::Outcome::kUndecided:
      return kExitUndecided;
    case validation::Outcome::kDifference:
      break;
  }
  return kExitDifference;
}

void add_peer_options(CLI::App* command, Options& options) {
  validation::ValidationSettings& settings = options.settings;
  command
      ->add_option("--model", options.shading,
                   "Principled BSDF: v1, against Blender 3.4; v2, against Blender 4.5")
      ->check(CLI::IsMember({"v1", "v2"}))
      ->capture_default_str();
  CLI::Option* blender = command->add_option("--blender", settings.blender,
                                             "Blender 3.4, or 4.5 for --model v2 (default: blender in PATH)");
  CLI::Option* bpy =
      command
          ->add_option("--bpy", settings.bpy,
                       "instead of --blender: a Python environment with Blender 4.5 as the module bpy")
          ->excludes(blender);
  command
      ->add_flag(
          "--install-bpy", options.install_bpy,
          "makes that environment if it is not there: fetches about 400 MB from PyPI, needs Python 3.11")
      ->needs(bpy);
}

void add_picture_options(CLI::App* command, Options& options) {
  validation::ValidationSettings& settings = options.settings;
  command->add_option("--view", options.view, "view k of n around the turn, k/n")->capture_default_str();
  command->add_option("--size", settings.size_px, "width and height in pixels")
      ->check(program::whole_within(8, 8192))
      ->capture_default_str();
  command->add_option("--spp", settings.spp, "paths a pixel of one image")
      ->check(program::whole_within(1, validation::kMaxCyclesSpp))
      ->capture_default_str();
  command->add_option("--seeds", settings.seeds, "images a side, each with its own seed")
      ->check(program::whole_within(2, 1024))
      ->capture_default_str();
  command->add_option("--bounces", settings.max_bounces, "indirect bounces at most")
      ->check(program::whole_within(0, 1024))
      ->capture_default_str();
  command
      ->add_option("--subsurface", options.subsurface,
                   "walk: light scatters under the skin; diffuse: on neither side")
      ->check(CLI::IsMember({"walk", "diffuse"}))
      ->capture_default_str();
  command
      ->add_option(
          "--focus", settings.focus,
          "regions that are too noisy are rendered again, alone, with up to so many times the work; 1: never")
      ->check(program::number_within(1.0, 1e6))
      ->capture_default_str();
}

}  // namespace

void add_validate_command(CLI::App& app, Commands& commands) {
  CLI::App* command = app.add_subcommand("validate", "The same view in Blender's Cycles and here, compared");
  auto options = std::make_shared<Options>();
  command->add_option("MODEL", options->model, "folder that bake wrote")->required();
  command->add_option("--environment", options->environment, "latitude-longitude map, linear")->required();
  add_peer_options(command, *options);
  add_picture_options(command, *options);
  command->add_flag("--keep-scene", options->keeps_scene,
                    "writes REPORT/scene.blend too: the scene as Cycles rendered it, whole in one file");
  command->add_option("-o,--output", options->output, "folder for the report")->required();
  add_common_options(*command, commands.common);
  add_seed_option(*command, commands.common);
  command->footer(program::help_footer(
      {"openhumanbrdf validate model --environment studio.exr -o report",
       "openhumanbrdf validate model --environment sunset.exr --view 25/100 --size 512 --spp 256 -o report",
       "openhumanbrdf validate model --environment studio.exr --model v2 --bpy bpy45 --install-bpy -o "
       "report"},
      "Exit code 0: both agree; 1: a difference; 3: no difference, but too noisy to be sure (the last line "
      "says what "
      "would decide it); 2: bad input."));
  command->callback([options, &commands] {
    commands.run = [options, &commands] { return run_validate(*options, commands.common); };
  });
}

}  // namespace ohb
