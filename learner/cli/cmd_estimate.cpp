#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "dataset/model/json_text.h"
#include "dataset/program/help.h"
#include "dataset/program/option_checks.h"
#include "learner/cli/commands.h"
#include "learner/estimate.h"

namespace ohb::learner {
namespace {

struct Arguments {
  learner::EstimateOptions estimate;
  std::string photo, mask, matting, output;
  std::vector<std::string> weights;
};

int run_estimate(Arguments arguments, const CommonOptions& common) {
  learner::EstimateOptions& o = arguments.estimate;
  o.photo = arguments.photo;
  if (!arguments.mask.empty()) o.mask = arguments.mask;
  if (!arguments.matting.empty()) o.matting.network = arguments.matting;
  o.weights.assign(arguments.weights.begin(), arguments.weights.end());
  o.output = arguments.output;
  use_threads(common.threads);
  const learner::EstimateReport report = learner::estimate(o);
  if (common.json) {
    const nlohmann::json json = {
        {"maps", arguments.output},
        {"size_px", report.size_px},
        {"finetuned", report.finetuned},
        {"people_found", report.people},
        {"photo_crop_px",
         {{"left", report.crop.left_px}, {"top", report.crop.top_px}, {"side", report.crop.side_px}}},
        {"seconds", report.seconds}};
    std::printf("%s\n", json_text(json, 2).c_str());
    return 0;
  }
  if (report.people > 1)
    std::printf("%d people found, by size; this is --person %d\n", report.people, o.matting.person);
  std::printf("%s: maps of %d x %d from a square of %.0f px, %s, %.2f s\n", arguments.output.c_str(),
              report.size_px, report.size_px, report.crop.side_px,
              report.finetuned ? "finetuned" : "not finetuned", report.seconds);
  return 0;
}

}  // namespace

void add_estimate_command(CLI::App& app, Commands& commands) {
  CLI::App* command = app.add_subcommand("estimate", "The maps of the person in a photograph");
  auto arguments = std::make_shared<Arguments>();
  command->add_option("PHOTO", arguments->photo, "PNG, JPEG, TIFF, EXR or HDR")->required();
  CLI::Option* mask =
      command->add_option("--mask", arguments->mask,
                          "picture that is white on the person (default: the photo's alpha, or --matting)");
  command
      ->add_option("--matting", arguments->matting,
                   "ONNX network that finds the person where there is no mask (default: GrabCut)")
      ->excludes(mask);
  command->add_option("--person", arguments->estimate.matting.person, "which of the people found, by size")
      ->check(program::whole_within(1, 1000))
      ->capture_default_str();
  command
      ->add_option("--weights", arguments->weights,
                   "runs or weights: joint, or geometry, albedo and rss; finetune or not")
      ->required();
  command
      ->add_option("--size", arguments->estimate.size_px,
                   "pixels of a side of the maps, a multiple of 16 (default: the photo's own, at most 1024)")
      ->check(program::whole_within(16, 4096));
  command
      ->add_option("--height", arguments->estimate.person_height_cm,
                   "height in cm of what the mask covers; sets the scale")
      ->check(program::number_within(1, 1000))
      ->capture_default_str();
  command->add_option("-o,--output", arguments->output, "folder for the maps")->required();
  add_common_options(*command, commands.common);
  command->footer(program::help_footer(
      {"humanmaterial estimate photo.jpg --matting selfie_segmentation.onnx --weights weights/*.safetensors "
       "-o maps",
       "humanmaterial estimate cutout.png --weights runs/geometry runs/albedo runs/rss runs/finetune -o maps",
       "humanmaterial estimate photo.jpg --mask mask.png --weights weights/*.safetensors --height 182 -o "
       "maps"}));
  command->callback([arguments, &commands] {
    commands.run = [arguments, &commands] { return run_estimate(*arguments, commands.common); };
  });
}

}  // namespace ohb::learner
