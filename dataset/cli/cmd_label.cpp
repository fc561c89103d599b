#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>

#include "dataset/cli/commands.h"
#include "dataset/commands/label.h"
#include "dataset/commands/label_serve.h"
#include "dataset/model/error.h"
#include "dataset/model/json_text.h"
#include "dataset/model/scan_unit.h"
#include "dataset/program/help.h"
#include "dataset/program/option_checks.h"

namespace ohb {
namespace {

struct Options {
  std::string scan, rules, faces, strokes, truth, unit, up, output;
  std::vector<std::string> classes, answers;
  std::string refine = "auto";
  float leather_share = labelling::kLeatherShare;
  bool automatic = false, serve = false;
};

int run_serve(const Options& options) {
  if (!options.rules.empty() || !options.faces.empty() || !options.truth.empty() || options.automatic ||
      !options.answers.empty() || !options.output.empty() || options.refine != "auto" ||
      options.leather_share != labelling::kLeatherShare)
    throw InputError("", "--serve", "takes only --strokes, --unit and --up", "leave the other options out");
  commands::serve_labels({options.scan, options.strokes, options.unit, options.up}, std::cin, std::cout);
  return 0;
}

int run_label(const Options& options, const CommonOptions& common) {
  if (options.serve) return run_serve(options);
  if (options.output.empty()) throw InputError("", "-o", "is missing", "name the folder for the regions");
  commands::LabelJob job;
  job.scan = options.scan;
  job.rules = options.rules;
  job.faces = options.faces;
  job.strokes = options.strokes;
  job.automatic = options.automatic;
  job.truth = options.truth;
  job.unit = options.unit;
  job.up = options.up;
  job.classes = options.classes;
  job.answers = options.answers;
  job.leather_share = options.leather_share;
  job.refine = options.refine == "on"    ? commands::RefineBorders::kOn
               : options.refine == "off" ? commands::RefineBorders::kOff
                                         : commands::RefineBorders::kAuto;
  job.output = options.output;
  const commands::LabelReport report = commands::label_scan(job);
  std::printf("%s", common.json ? (json_text(commands::to_json(report), 2) + "\n").c_str()
                                : commands::to_text(report).c_str());
  return 0;
}

}  // namespace

void add_label_command(CLI::App& app, Commands& commands) {
  CLI::App* command =
      app.add_subcommand("label", "Skin, hair, fabric or leather: the class of each face of a scan");
  auto options = std::make_shared<Options>();
  command->add_option("SCAN", options->scan, "mesh: OBJ, GLB or FBX")->required();
  command->add_option("--rules", options->rules, "rules.xml: classes by names, UV place and colour");
  command->add_option("--faces", options->faces,
                      "finished classes: one index a line, in the order of the faces");
  command->add_option("--strokes", options->strokes, "strokes.xml: classes painted on the surface");
  command->add_flag("--automatic", options->automatic,
                    "classes from body, colour and texture, whatever the names say");
  command->add_option("--answer", options->answers,
                      "NAME=CLASS: answers a question of the report (trousers=leather); once each");
  command
      ->add_option(
          "--leather-share", options->leather_share,
          "how many of the garments, shoes apart, are leather among people like this one (default: 0.05)")
      ->check(program::number_within(0.01, 0.99));
  command
      ->add_option("--classes", options->classes,
                   "what the indices mean (default: the JSON beside the file, else skin,hair,fabric,leather)")
      ->delimiter(',');
  command->add_option("--truth", options->truth, "known classes, as --faces: prints accuracy and IoU");
  command->add_option("--unit", options->unit, kUnitHelp);
  command->add_option("--up", options->up, kUpHelp);
  command
      ->add_option(
          "--refine", options->refine,
          "borders follow the picture through faces: on, off, or auto: where classes are inferred and "
          "faces are large")
      ->check(CLI::IsMember({"auto", "on", "off"}));
  command->add_flag("--serve", options->serve,
                    "answer strokes as they come: JSON lines on stdin and stdout, for painting tools");
  command->add_option("-o,--output", options->output, "folder for the regions (needed, but for --serve)");
  add_common_options(*command, commands.common);
  command->footer(
      program::help_footer({"openhumanbrdf label person.obj --rules rules.xml -o regions",
                            "openhumanbrdf label person.obj --faces person.labels.txt --classes "
                            "skin,hair,fabric,leather -o regions",
                            "openhumanbrdf label person.obj --strokes strokes.xml -o regions",
                            "openhumanbrdf label person.obj --serve"},
                           "With none of them the names of materials and groups decide, and where these "
                           "say nothing body, colour and texture."));
  command->callback([options, &commands] {
    commands.run = [options, &commands] { return run_label(*options, commands.common); };
  });
}

}  // namespace ohb
