#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "dataset/cli/commands.h"
#include "dataset/exports/exports.h"
#include "dataset/model/error.h"
#include "dataset/model/json_text.h"
#include "dataset/program/help.h"
#include "dataset/program/option_checks.h"

namespace ohb {
namespace {

struct Options {
  exports::ExportJob job;
  bool png = false, webdataset = false, page = false;
};

int run_export(Options options, const CommonOptions& common) {
  if (options.png + options.webdataset + options.page != 1)
    throw InputError("", "export", "needs one of --png, --webdataset and --page",
                     "give the form that you want");
  options.job.form = options.png          ? exports::Form::kPng
                     : options.webdataset ? exports::Form::kWebDataset
                                          : exports::Form::kPage;
  options.job.quiet = common.json;
  const exports::ExportReport report = exports::export_samples(options.job);
  if (common.json) {
    const nlohmann::json json = {
        {"samples", report.samples}, {"people", report.people}, {"files", report.files}};
    std::printf("%s\n", json_text(json, 2).c_str());
  } else {
    std::printf("%s: %zu samples of %zu people, %zu files\n", options.job.output.c_str(), report.samples,
                report.people, report.files);
  }
  return 0;
}

}  // namespace

void add_export_command(CLI::App& app, Commands& commands) {
  CLI::App* command =
      app.add_subcommand("export", "Samples as PNG, as tar shards, or as a page to look through");
  auto options = std::make_shared<Options>();
  command->add_option("input", options->job.input, "folder that produce or render wrote")->required();
  command->add_flag("--png", options->png, "a folder a sample, with mask, maps and pictures");
  command->add_flag("--webdataset", options->webdataset, "tar shards of the samples as they are");
  command->add_flag("--page", options->page, "index.html with thumbnails and filters, CARD.md");
  command->add_option("--bits", options->job.bits, "of a value of --png")
      ->check(CLI::IsMember({8, 16}))
      ->capture_default_str();
  command->add_option("--shard-size", options->job.samples_a_shard, "samples in a tar file")
      ->check(program::whole_within(1, 100000))
      ->capture_default_str();
  command->add_option("-o,--output", options->job.output, "folder to write")->required();
  add_common_options(*command, commands.common);
  command->footer(program::help_footer({"openhumanbrdf export dataset --png --bits 16 -o pictures",
                                        "openhumanbrdf export dataset --webdataset -o shards",
                                        "openhumanbrdf export dataset --page -o page"}));
  command->callback([options, &commands] {
    commands.run = [options, &commands] { return run_export(*options, commands.common); };
  });
}

}  // namespace ohb
