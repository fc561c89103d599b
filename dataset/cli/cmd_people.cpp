#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "dataset/cli/commands.h"
#include "dataset/people/people.h"

namespace ohb {
namespace {

int run_people(people::PeopleJob job, const CommonOptions& common) {
  job.draw.seed = common.seed;
  job.quiet = common.json;
  const people::PeopleReport report = people::make_people(job);
  if (common.json) {
    std::printf("%s\n", people::to_json(report).dump(2).c_str());
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
      ->check(CLI::Range(1, people::kMaxPeople))
      ->required();
  command->add_flag("--balanced", job->draw.balanced,
                    "half women, the six groups evenly (any multiple of 12); default: at random");
  command->add_option("--atlas", job->scan.atlas_px, "width and height of the picture in texels")
      ->check(CLI::Range(256, 8192))
      ->capture_default_str();
  command
      ->add_option("--noise", job->scan.faults.noise_cm,
                   "standard deviation of the surface in cm, as scanners have it")
      ->check(CLI::Range(0.0f, 2.0f))
      ->capture_default_str();
  command->add_option("--holes", job->scan.faults.holes, "patches of 1 to 4 cm that were not captured")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  command->add_flag("--baked-shading", job->scan.faults.shading, "soft light and its shadows in the picture");
  command->add_option("-o,--output", job->output, "folder for the people")->required();
  add_common_options(*command, commands.common);
  command->footer(
      "Examples:\n"
      "  openhumanbrdf people --assets makehuman --count 147 --balanced -o people\n"
      "  openhumanbrdf people --assets makehuman --count 12 --seed 7 --atlas 4096 -o people\n"
      "  openhumanbrdf people --assets makehuman --count 12 --noise 0.1 --holes 10 --baked-shading --atlas "
      "1024 -o hard\n"
      "An interrupted run goes on where it stopped when the same command is given again.");
  command->callback(
      [job, &commands] { commands.run = [job, &commands] { return run_people(*job, commands.common); }; });
}

}  // namespace ohb
