#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "dataset/model/json_text.h"
#include "dataset/model/regions.h"
#include "dataset/program/help.h"
#include "dataset/program/option_checks.h"
#include "learner/cli/commands.h"
#include "learner/relight.h"

namespace ohb::learner {
namespace {

struct Arguments {
  learner::RelightOptions relight;
  std::string maps, environment, blender, output;
};

int run_relight(Arguments arguments, const CommonOptions& common) {
  learner::RelightOptions& o = arguments.relight;
  o.maps = arguments.maps;
  o.environment = arguments.environment;
  o.blender = arguments.blender;
  o.output = arguments.output;
  o.seed = common.seed;
  o.threads = common.threads;
  const nlohmann::json report = learner::relight(o);
  if (common.json) {
    std::printf("%s\n", json_text(report, 2).c_str());
    return 0;
  }
  const auto& size = report.at("size_px");
  const auto& seconds = report.at("seconds");
  std::printf("%s: %d x %d, Blender %s, %.1f s to load, %.1f s to render\n", arguments.output.c_str(),
              size.at(0).get<int>(), size.at(1).get<int>(), report.at("blender").get<std::string>().c_str(),
              seconds.at("load").get<double>(), seconds.at("render").get<double>());
  return 0;
}

void add_light_options(CLI::App& command, Arguments& arguments) {
  learner::RelightOptions& o = arguments.relight;
  command.add_option("--environment", arguments.environment, "latitude-longitude picture, linear EXR or HDR");
  command
      .add_option("--rotation", o.rotation_deg,
                  "degrees by which it turns; after 90, light from the viewer comes from the right")
      ->check(program::number_within(-36000, 36000))
      ->capture_default_str();
  command.add_option("--strength", o.strength, "factor on the environment")
      ->check(program::number_within(0, 1e6))
      ->capture_default_str();
  command.add_option("--point", o.points, "point light x,y,z,I: cm, and irradiance at 1 m; may be repeated")
      ->allow_extra_args(false);
  command.add_option("--background", o.background, "behind the person")
      ->check(CLI::IsMember({"transparent", "environment"}))
      ->capture_default_str();
}

}  // namespace

void add_relight_command(CLI::App& app, Commands& commands) {
  CLI::App* command =
      app.add_subcommand("relight", "The estimated person in Blender, relit and edited, without a window");
  auto arguments = std::make_shared<Arguments>();
  learner::RelightOptions& o = arguments->relight;
  command->add_option("MAPS", arguments->maps, "folder that estimate wrote")->required();
  add_light_options(*command, *arguments);
  command
      ->add_option("--edit", o.edits,
                   "CLASS:PRESET or CLASS:#rrggbb; CLASS is " + class_list() + "; may be repeated")
      ->allow_extra_args(false);
  command->add_option("--subsurface-scale", o.subsurface_scale, "factor on the subsurface map")
      ->check(program::number_within(0, 1000))
      ->capture_default_str();
  command->add_option("--size", o.size_px, "width of the picture in pixels (default: that of the maps)")
      ->check(program::whole_within(1, 16384));
  command->add_option("--spp", o.spp, "samples a pixel")
      ->check(program::whole_within(1, 1 << 20))
      ->capture_default_str();
  command->add_option("--blender", arguments->blender,
                      "program of Blender 3.4 or later (default: blender in PATH)");
  command->add_option("-o,--output", arguments->output, "picture, .png or .exr")->required();
  add_common_options(*command, commands.common);
  add_seed_option(*command, commands.common, INT32_MAX);
  command->footer(program::help_footer(
      {"humanmaterial relight maps --environment sunset.exr --rotation 40 -o relit.png",
       "humanmaterial relight maps --point 100,220,200,5 --edit fabric:shiny_leather --edit "
       "hair:auburn -o edited.png"}));
  command->callback([arguments, &commands] {
    commands.run = [arguments, &commands] { return run_relight(*arguments, commands.common); };
  });
}

}  // namespace ohb::learner
