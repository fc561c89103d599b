#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "dataset/cli/commands.h"
#include "dataset/commands/bake_scan.h"
#include "dataset/model/json_text.h"
#include "dataset/model/scan_unit.h"
#include "dataset/program/help.h"
#include "dataset/program/option_checks.h"

namespace ohb {
namespace {

int run_bake(commands::BakeJob job, const CommonOptions& common) {
  job.quiet = common.json;
  const commands::BakeScanReport report = commands::bake_scan(job);
  std::printf("%s", common.json ? (json_text(to_json(report), 2) + "\n").c_str() : to_text(report).c_str());
  return 0;
}

void add_scan_options(CLI::App* command, commands::BakeJob& job) {
  command->add_option("SCAN", job.scan, "mesh: OBJ, GLB or FBX")->required();
  command->add_option("--regions", job.regions, "folder that label wrote for this scan")->required();
  command->add_option("--materials", job.materials,
                      "specular, roughness and sss of the classes (default: the paper's)");
  command
      ->add_option("--size", job.size_px,
                   "texels along the longer edge of the maps (default: those of the diffuse picture)")
      ->check(program::whole_within(1, bake::kMaxMapSize_px));
  command->add_option("--unit", job.unit, kUnitHelp);
  command->add_option("--name", job.name, "name of the model (default: that of the scan's file)");
  command
      ->add_option(
          "--normals", job.normals,
          "green of the scan's normal maps: opengl (up), directx (down), auto (told from the picture)")
      ->capture_default_str();
}

void add_source_options(CLI::App* command, commands::BakeJob& job) {
  command->add_option(
      "--source", job.source,
      "high-resolution mesh of the same subject, in the same place: colours, normals and relief "
      "come from it");
  command->add_option("--source-unit", job.source_unit,
                      "unit of the source (default: as its file states, else that of the scan)");
  command
      ->add_option("--reach", job.reach_cm,
                   "cm that the source may lie outside or inside the scan (default: 1 % of its diagonal)")
      ->check(program::number_within(1e-6, 1e6));
  command->add_option("--cage", job.cage,
                      "the scan with its points moved outwards: how far the source may lie outside, point by "
                      "point");
  command
      ->add_option("--max-missed", job.max_missed_percent,
                   "percent of a set's texels that may miss the source")
      ->check(program::number_within(0.0, 100.0))
      ->capture_default_str();
  command
      ->add_option("--max-overlap", job.max_overlap_percent,
                   "percent of a set's texels that may show two faces, with a source")
      ->check(program::number_within(0.0, 100.0))
      ->capture_default_str();
  command->add_flag("--object-normals", job.wants_object_normals,
                    "write the source's normals in the model's axes too (normal_object.exr)");
}

}  // namespace

void add_bake_command(CLI::App& app, Commands& commands) {
  CLI::App* command = app.add_subcommand("bake", "The UV maps of a labelled scan, as a renderable model");
  auto job = std::make_shared<commands::BakeJob>();
  add_scan_options(command, *job);
  add_source_options(command, *job);
  command->add_flag("--mips", job->wants_mips,
                    "write the maps tiled and with their mip levels, each with its seams made to agree");
  command->add_flag("--keep-seams", job->keeps_seams,
                    "leave the texels at seams as they are (default: both sides are made to agree)");
  command->add_flag("--delight", job->delights,
                    "divide the scan's pictures by the light of its surroundings, where they follow it");
  command->add_option("-o,--output", job->output, "folder for the model")->required();
  add_common_options(*command, commands.common);
  command->footer(program::help_footer(
      {"openhumanbrdf bake person.obj --regions regions -o model",
       "openhumanbrdf bake person.glb --regions regions --size 4096 --unit m -o model",
       "openhumanbrdf bake low.obj --regions regions --source high.obj --size 4096 -o model",
       "openhumanbrdf bake person.obj --regions regions --delight -o model"}));
  command->callback(
      [job, &commands] { commands.run = [job, &commands] { return run_bake(*job, commands.common); }; });
}

}  // namespace ohb
