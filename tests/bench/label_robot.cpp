// A robot paints strokes on labelled scans: accuracy against the number of strokes, of ours and of four
// simpler ways, with and without noise, and under wrong strokes and damaged pictures. usage: label_robot
// [--strokes 20] [--stress | --ours] SCAN.obj... -o FOLDER   (x_scan.obj with x_scan.labels.txt)
// Or without a stroke: what is right, in doubt, asked, and right once it is answered: label_robot --trust
// SCAN.obj..., and each person by what was learned from the others: label_robot --fit MODEL.json SCAN.obj...
#include <CLI/CLI.hpp>
#include <cstdio>

#include "dataset/model/atomic_file.h"
#include "dataset/model/atomic_folder.h"
#include "dataset/model/data_files.h"
#include "dataset/model/error.h"
#include "tests/bench/robot_run.h"
#include "tests/bench/robot_stress.h"
#include "tests/bench/robot_trust.h"

namespace ohb {
using namespace labelling;
using namespace surface;
namespace {

std::vector<RobotMethod> methods() {
  LabelTerms colour, potts, walk;
  colour.prior = colour.walk = colour.reach = colour.border = false;
  potts.colour = potts.walk = potts.reach = potts.likeness = false;
  walk.colour = walk.reach = walk.border = false;
  return {{"ours", {}},
          {"nearest stroke", {}, true},
          {"colour model alone", colour},
          {"uniform Potts", potts},
          {"random walk alone", walk}};
}

void compare_methods(const std::vector<RobotHuman>& humans, bool is_ours_alone, int strokes,
                     std::vector<RobotPoint>& points) {
  const RobotNoise noise{0.3, 0.02};
  std::vector<RobotMethod> compared = methods();
  if (is_ours_alone) compared.resize(1);
  for (const RobotMethod& method : compared)
    for (const RobotHuman& human : humans) {
      run_robot(human, method.name, method, {}, strokes, points);
      run_robot(human, std::string(method.name) + ", noisy", method, noise, strokes, points);
    }
}

int run_stress(const std::vector<RobotHuman>& humans, int strokes, AtomicFolder& folder) {
  const std::vector<RobotStressCase> cases =
      read_robot_stress(program_file("assets/stress/label_catalogue.json"));
  const std::vector<RobotStressResult> results = run_robot_stress(cases, humans, strokes);
  write_file_atomically(folder.path() / "chart.csv", robot_stress_csv(results));
  std::printf("%s", robot_stress_text(results).c_str());
  draw_robot_stress(results, folder.path());
  folder.commit();
  for (const RobotStressResult& result : results)
    if (!result.failure.empty()) return kExitDifference;
  return kExitDone;
}

std::vector<RobotHuman> read_humans(const std::vector<std::string>& files) {
  std::vector<RobotHuman> humans;
  for (const std::string& file : files) humans.push_back(read_robot_human(file));
  return humans;
}

int run(const std::vector<std::string>& files, bool is_stress, bool is_ours_alone, int strokes,
        const std::string& output) {
  const std::vector<RobotHuman> humans = read_humans(files);
  AtomicFolder folder(output, "chart of labels");
  if (is_stress) return run_stress(humans, strokes, folder);
  std::vector<RobotPoint> points;
  compare_methods(humans, is_ours_alone, strokes, points);
  write_file_atomically(folder.path() / "chart.csv", robot_csv(points));
  std::printf("%s", robot_table(points).c_str());
  draw_robot_chart(points, folder.path());
  folder.commit();
  return 0;
}

}  // namespace
}  // namespace ohb

int main(int argc, char** argv) {
  CLI::App app("Accuracy of labels against the number of strokes of a robot");
  std::vector<std::string> scans;
  std::string output, fitted;
  int strokes = 20;
  float leather_share = ohb::labelling::kLeatherShare;
  bool is_stress = false, is_ours_alone = false, is_trust = false;
  app.add_option("SCAN", scans, "x.obj with x.labels.txt beside it")->required();
  app.add_option("--strokes", strokes, "strokes a scan")->check(CLI::Range(1, 200));
  app.add_flag(
      "--stress", is_stress,
      "ours alone, in the cases of assets/stress/label_catalogue.json; exit code 1 beyond its limits");
  app.add_flag("--ours", is_ours_alone, "without the simpler ways");
  app.add_flag("--trust", is_trust,
               "no stroke: what is right, in doubt and asked, reliability, and what is right with answers");
  app.add_option(
      "--fit", fitted,
      "--trust, each person by what was learned from the others; what was learned from all goes to "
      "this file (assets/label_model.json)");
  app.add_option("--leather-share", leather_share, "of --trust and --fit: as label's, of these people")
      ->check(CLI::Range(0.01, 0.99));
  app.add_option("-o,--output", output, "folder for chart.csv, .svg and .png (needed without --trust)");
  CLI11_PARSE(app, argc, argv);
  try {
    if (is_trust || !fitted.empty()) {
      ohb::measure_trust(ohb::read_humans(scans), fitted, leather_share);
      return ohb::kExitDone;
    }
    if (output.empty()) throw ohb::InputError("", "-o", "is missing", "name the folder for the chart");
    return ohb::run(scans, is_stress, is_ours_alone, strokes, output);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "label_robot: %s\n", error.what());
    return 2;
  }
}
