#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "dataset/cli/commands.h"
#include "dataset/model/json_text.h"
#include "dataset/people/people.h"
#include "dataset/program/help.h"
#include "dataset/program/option_checks.h"

namespace ohb {
namespace {

int run_people(people::PeopleJob job, const CommonOptions& common) {
  job.draw.seed = common.seed;
  job.quiet = common.json;
  const people::PeopleReport report = people::make_people(job);
  if (common.json) {
    std::printf("%s\n", json_text(people::to_json(report), 2).c_str());
    return 0;
  }
  size_t there = 0;
  for (const people::MadePerson& made : report.people) there += made.was_there;
  std::printf("%s: %zu people made, %zu were there, %.0f s\n", job.output.c_str(),
              report.people.size() - there, there, report.seconds);
  return 0;
}

}  // namespace

void add_people_command(CLI::App& app, Commands& commands) {
  CLI::App* command =
      app.add_subcommand("people", "Dressed, posed people as scans, from MakeHuman's free assets");
  auto job = std::make_shared<people::PeopleJob>();
  command
      ->add_option("--assets", job->assets,
                   "folder with 3dobjs, targets, rigs, clothes, hair, skins, eyes, poses")
      ->required();
  command->add_option("--count", job->count, "people to make")
      ->check(program::whole_within(1, people::kMaxPeople))
      ->required();
  command->add_flag("--balanced", job->draw.balanced,
                    "half women, the six groups evenly (any multiple of 12); default: at random");
  command->add_option("--atlas", job->scan.atlas_px, "width and height of the picture in texels")
      ->check(program::whole_within(256, 8192))
      ->capture_default_str();
  command
      ->add_option("--noise", job->scan.faults.noise_cm,
                   "standard deviation of the surface in cm, as scanners have it")
      ->check(program::number_within(0, 2))
      ->capture_default_str();
  command->add_option("--holes", job->scan.faults.holes, "patches of 1 to 4 cm that were not captured")
      ->check(program::whole_within(0, 1000))
      ->capture_default_str();
  command->add_flag("--fused", job->fused,
                    "one closed surface over skin, hair and clothes, as photogrammetry gives");
  command->add_flag("--baked-shading", job->scan.faults.shading, "soft light and its shadows in the picture");
  command->add_option("-o,--output", job->output, "folder for the people")->required();
  add_common_options(*command, commands.common);
  add_seed_option(*command, commands.common);
  command->footer(program::help_footer(
      {"openhumanbrdf people --assets makehuman --count 147 --balanced -o people",
       "openhumanbrdf people --assets makehuman --count 12 --seed 7 --atlas 4096 -o people",
       "openhumanbrdf people --assets makehuman --count 12 --fused --noise 0.1 --holes 10 "
       "--baked-shading --atlas 1024 -o "
       "hard"},
      "An interrupted run goes on where it stopped when the same command is given again."));
  command->callback(
      [job, &commands] { commands.run = [job, &commands] { return run_people(*job, commands.common); }; });
}

}  // namespace ohb
