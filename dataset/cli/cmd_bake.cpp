#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "dataset/cli/commands.h"
#include "dataset/production/bake_scan.h"

namespace ohb {
namespace {

struct Options {
  std::string scan, regions, materials, unit, name, normals = "auto", output;
  int size_px = 0;
};

int run_bake(const Options& options, const CommonOptions& common) {
  BakeJob job;
  job.scan = options.scan;
  job.regions = options.regions;
  job.materials = options.materials;
  job.unit = options.unit;
  job.name = options.name;
  job.normals = options.normals;
  job.quiet = common.json;
  job.size_px = options.size_px;
  job.output = options.output;
  const BakeReport report = bake_scan(job);
  std::printf("%s", common.json ? (to_json(report).dump(2) + "\n").c_str() : to_text(report).c_str());
  return 0;
}

}  // namespace

void add_bake_command(CLI::App& app, Commands& commands) {
  CLI::App* command = app.add_subcommand("bake", "The six UV maps of a labelled scan, as a renderable model");
  auto options = std::make_shared<Options>();
  command->add_option("SCAN", options->scan, "mesh: OBJ, GLB or FBX")->required();
  command->add_option("--regions", options->regions, "folder that label wrote for this scan")->required();
  command->add_option("--materials", options->materials,
                      "specular, roughness and sss of the classes (default: the paper's)");
  command
      ->add_option("--size", options->size_px,
                   "texels along the longer edge of the maps (default: those of the diffuse picture)")
      ->check(CLI::Range(1, kMaxMapSize_px));
  command->add_option("--unit", options->unit, "unit of the scan: mm, cm, m or inch (default: guessed)");
  command->add_option("--name", options->name, "name of the model (default: that of the scan's file)");
  command
      ->add_option(
          "--normals", options->normals,
          "green of the scan's normal maps: opengl (up), directx (down), auto (told from the picture)")
      ->capture_default_str();
  command->add_option("-o,--output", options->output, "folder for the model")->required();
  add_common_options(*command, commands.common);
  command->footer(
      "Examples:\n"
      "  openhumanbrdf bake person.obj --regions regions -o model\n"
      "  openhumanbrdf bake person.glb --regions regions --size 4096 --unit m -o model");
  command->callback([options, &commands] {
    commands.run = [options, &commands] { return run_bake(*options, commands.common); };
  });
}

}  // namespace ohb
