#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "dataset/cli/commands.h"
#include "dataset/commands/source_materials.h"
#include "dataset/model/atomic_file.h"
#include "dataset/model/atomic_folder.h"
#include "dataset/model/error.h"
#include "dataset/program/help.h"
#include "dataset/program/option_checks.h"
#include "dataset/studies/bake_fidelity.h"

namespace ohb {
namespace fs = std::filesystem;
namespace {

struct Options {
  commands::BakeJob job;
  std::string environment, output;
  bool hard_borders = false;
  studies::FidelitySettings settings;
};

/// Twice the pictures' size, their own, and halves of it.
std::vector<int> usual_sizes(int picture_px) {
  std::vector<int> sizes = {0};
  if (2 * picture_px <= bake::kMaxMapSize_px) sizes.insert(sizes.begin(), 2 * picture_px);
  for (int halvings = 1; halvings <= 5 && (picture_px >> halvings) >= 16; ++halvings)
    sizes.push_back(picture_px >> halvings);
  return sizes;
}

int run_bake_chart(const Options& options, const CommonOptions& common) {
  studies::FidelitySettings settings = options.settings;
  settings.seed = common.seed;
  auto inputs = commands::read_bake_inputs(options.job);
  if (options.hard_borders) inputs->options.class_weights.clear();
  if (settings.map_sizes_px.empty())
    settings.map_sizes_px = usual_sizes(commands::largest_picture_px(inputs->scan));
  const Environment environment = read_environment(options.environment);
  AtomicFolder folder(options.output, "chart of bakes",
                      {options.job.scan, options.job.regions, options.job.materials, options.environment});
  const studies::BakeFidelity fidelity = studies::measure_bake_fidelity(*inputs, environment, settings);
  write_file_atomically(folder.path() / "chart.csv", studies::fidelity_csv(fidelity));
  write_file_atomically(folder.path() / "chart.json", studies::fidelity_json(fidelity));
  studies::draw_fidelity(fidelity, folder.path());
  folder.commit();
  std::printf("%s",
              (common.json ? studies::fidelity_json(fidelity) : studies::fidelity_text(fidelity)).c_str());
  if (!common.json) std::printf("%s\n", (fs::path(options.output) / "chart.svg").c_str());
  return fidelity.passes() ? kExitDone : kExitDifference;
}

void add_picture_options(CLI::App* command, studies::FidelitySettings& settings) {
  command->add_option("--size", settings.size_px, "width and height of the picture in pixels")
      ->check(program::whole_within(8, 8192))
      ->capture_default_str();
  command->add_option("--spp", settings.spp, "paths a pixel of one image")
      ->check(program::whole_within(1, 8192))
      ->capture_default_str();
  command->add_option("--seeds", settings.seeds, "images of each kind, each with its own seed")
      ->check(program::whole_within(2, 256))
      ->capture_default_str();
}

}  // namespace

void add_bake_chart(CLI::App& chart, Commands& commands) {
  CLI::App* command =
      chart.add_subcommand("bake", "Baked maps beside the scan's own materials, against the maps' size");
  auto options = std::make_shared<Options>();
  options->job.quiet = true;
  studies::FidelitySettings& settings = options->settings;
  command->add_option("SCAN", options->job.scan, "mesh: OBJ, GLB or FBX")->required();
  command->add_option("--regions", options->job.regions, "folder that label wrote for this scan")->required();
  command->add_option("--environment", options->environment, "latitude-longitude map, linear")->required();
  command->add_option("--materials", options->job.materials,
                      "specular, roughness and sss of the classes (default: the paper's)");
  command->add_flag("--keep-seams", options->job.keeps_seams, "bake with --keep-seams");
  command->add_option("--unit", options->job.unit, "unit of the scan: mm, cm, m or inch (default: guessed)");
  command
      ->add_option("--map-sizes", settings.map_sizes_px,
                   "texels along the longer edge of the maps, several (default: twice the pictures' size, "
                   "their own, a half, ... )")
      ->check(program::whole_within(1, bake::kMaxMapSize_px));
  command->add_flag("--hard-borders", options->hard_borders,
                    "classes change at the faces' edges; the regions' weights are not used");
  add_picture_options(command, settings);
  command->add_option("-o,--output", options->output, "folder for chart.svg, .png, .csv and .json")
      ->required();
  add_common_options(*command, commands.common);
  add_seed_option(*command, commands.common);
  command->footer(program::help_footer(
      {"openhumanbrdf chart bake person.obj --regions regions --environment studio.exr -o chart",
       "openhumanbrdf chart bake person.obj --regions regions --environment studio.exr "
       "--map-sizes 2048 512 -o chart"},
      "Exit code 1: maps of the pictures' size do not render as the scan's own materials."));
  command->callback([options, &commands] {
    commands.run = [options, &commands] { return run_bake_chart(*options, commands.common); };
  });
}

}  // namespace ohb
