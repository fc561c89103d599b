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
  commands::LabelJob job;
  std::string refine = "auto";
  bool serve = false;
};

int run_serve(const Options& options) {
  const commands::LabelJob& job = options.job;
  if (!job.rules.empty() || !job.faces.empty() || !job.truth.empty() || job.automatic ||
      !job.answers.empty() || !job.output.empty() || options.refine != "auto" ||
      job.leather_share != labelling::kLeatherShare)
    throw InputError("", "--serve", "takes only --strokes, --unit and --up", "leave the other options out");
  commands::serve_labels({job.scan, job.strokes, job.unit, job.up}, std::cin, std::cout);
  return 0;
}

int run_label(Options options, const CommonOptions& common) {
  if (options.serve) return run_serve(options);
  commands::LabelJob& job = options.job;
  if (job.output.empty()) throw InputError("", "-o", "is missing", "name the folder for the regions");
  job.refine = options.refine == "on"    ? commands::RefineBorders::kOn
               : options.refine == "off" ? commands::RefineBorders::kOff
                                         : commands::RefineBorders::kAuto;
  const commands::LabelReport report = commands::label_scan(job);
  std::printf("%s", common.json ? (json_text(commands::to_json(report), 2) + "\n").c_str()
                                : commands::to_text(report).c_str());
  return 0;
}

void add_label_sources(CLI::App* command, commands::LabelJob& job) {
  command->add_option("SCAN", job.scan, "mesh: OBJ, GLB or FBX")->required();
  command->add_option("--rules", job.rules, "rules.xml: classes by names, UV place and colour");
  command->add_option("--faces", job.faces, "finished classes: one index a line, in the order of the faces");
  command->add_option("--strokes", job.strokes, "strokes.xml: classes painted on the surface");
  command->add_flag("--automatic", job.automatic,
                    "classes from body, colour and texture, whatever the names say");
  command->add_option("--answer", job.answers,
                      "NAME=CLASS: answers a question of the report (trousers=leather); once each");
  command
      ->add_option(
          "--leather-share", job.leather_share,
          "how many of the garments, shoes apart, are leather among people like this one (default: 0.05)")
      ->check(program::number_within(0.01, 0.99));
  command
      ->add_option(
          "--classes", job.classes,
          "what the indices mean (default: the JSON beside the file, else " + class_list(",", ",") + ")")
      ->delimiter(',');
  command->add_option("--truth", job.truth, "known classes, as --faces: prints accuracy and IoU");
  command->add_option("--unit", job.unit, kUnitHelp);
  command->add_option("--up", job.up, kUpHelp);
}

}  // namespace

void add_label_command(CLI::App& app, Commands& commands) {
  CLI::App* command = app.add_subcommand("label", "The class of each face of a scan: " + class_list());
  auto options = std::make_shared<Options>();
  add_label_sources(command, options->job);
  command
      ->add_option(
          "--refine", options->refine,
          "borders follow the picture through faces: on, off, or auto: where classes are inferred and "
          "faces are large")
      ->check(CLI::IsMember({"auto", "on", "off"}));
  command->add_flag("--serve", options->serve,
                    "answer strokes as they come: JSON lines on stdin and stdout, for painting tools");
  command->add_option("-o,--output", options->job.output, "folder for the regions (needed, but for --serve)");
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
