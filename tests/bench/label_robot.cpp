// A robot paints strokes on labelled scans: accuracy against the number of strokes, of ours and of four
// simpler ways, with and without noise, and under wrong strokes and damaged pictures. usage: label_robot
// [--strokes 20] [--stress | --ours] SCAN.obj... -o FOLDER   (x_scan.obj with x_scan.labels.txt)
#include <CLI/CLI.hpp>

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cstdio>

#include "dataset/labelling/labeller.h"
#include "dataset/model/atomic_file.h"
#include "dataset/model/scan_unit.h"
#include "dataset/production/label.h"
#include "tests/bench/damaged_picture.h"
#include "tests/bench/robot_chart.h"
#include "tests/bench/robot_user.h"

namespace ohb {
namespace {

struct Human {
  std::string name;
  Scan scan;
  std::vector<uint8_t> truth;
  std::vector<double> area;
};

Human read_human(const std::filesystem::path& file) {
  Human human{file.stem().string(), read_scan(file), {}, {}};
  std::filesystem::path labels = file;
  labels.replace_extension(".labels.txt");
  human.truth = read_face_classes(labels, human.scan.face_count(), class_order_of(labels, file));
  human.area = face_areas(human.scan);
  return human;
}

/// One way to label. `nearest`: the class of the nearest stroke, nothing else.
struct Method {
  const char* name;
  LabelTerms terms;
  bool nearest = false;
};

std::vector<Method> methods() {
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

double processor_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

/// Paints up to `count` strokes, each on what is then most wrong.
void run_robot(const Human& human, const std::string& series, const Method& method, const RobotNoise& noise,
               int count, std::vector<RobotPoint>& points) {
  Labeller labeller(human.scan, guess_unit(human.scan).unit_cm.value_or(1), method.terms);
  const FaceGraph& graph = labeller.features().graph;
  std::mt19937 random(static_cast<uint32_t>(human.scan.face_count()));  // another one each
  std::vector<Stroke> strokes;
  const std::vector<uint8_t> start = labeller.solve({}).face_class;
  std::vector<uint8_t> face_class = start;
  RobotPoint point{series, human.name, 0, 0, 0, 0, 0};
  for (int n = 0; n <= count; ++n) {
    Stroke stroke;
    if (n > 0) stroke = next_stroke(graph, labeller.unit_cm(), face_class, human.truth, noise, random);
    if (!stroke.points.empty()) {
      stroke.time_s = n;
      strokes.push_back(stroke);
      const auto wall = std::chrono::steady_clock::now();
      const double cpu = processor_seconds();
      face_class = method.nearest ? nearest_stroke_classes(graph, labeller.unit_cm(), strokes, start)
                                  : labeller.solve(strokes).face_class;
      point.cpu_s = processor_seconds() - cpu;
      point.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - wall).count();
    }
    const TruthComparison truth = compare_with_truth(face_class, human.truth, human.area);
    point.strokes = n;
    point.accuracy = truth.accuracy;
    point.worst_iou = 1;
    for (const auto& iou : truth.iou) point.worst_iou = std::min(point.worst_iou, iou.value_or(1));
    points.push_back(point);
  }
}

void compare_methods(const std::vector<Human>& humans, bool is_ours_alone, int strokes,
                     std::vector<RobotPoint>& points) {
  const RobotNoise noise{0.3, 0.02};
  std::vector<Method> compared = methods();
  if (is_ours_alone) compared.resize(1);
  for (const Method& method : compared)
    for (const Human& human : humans) {
      run_robot(human, method.name, method, {}, strokes, points);
      run_robot(human, std::string(method.name) + ", noisy", method, noise, strokes, points);
    }
}

void stress(const std::vector<Human>& humans, int strokes, std::vector<RobotPoint>& points) {
  const Method ours = methods().front();
  for (const Human& human : humans) {
    for (const double wrong : {0.03, 0.1, 0.2, 0.35, 0.5})
      run_robot(human, std::to_string(std::lround(100 * wrong)) + " % wrong strokes", ours, {0, wrong},
                strokes, points);
    for (const double noise : {0.05, 0.15}) {
      Human damaged = human;
      add_noise(damaged.scan, noise);
      run_robot(damaged, "picture noise " + std::to_string(std::lround(255 * noise)) + " of 255", ours, {},
                strokes, points);
    }
    for (const int radius_px : {4, 12}) {
      Human damaged = human;
      blur(damaged.scan, radius_px);
      run_robot(damaged, "picture blurred over " + std::to_string(2 * radius_px + 1) + " px", ours, {},
                strokes, points);
    }
  }
}

int run(const std::vector<std::string>& files, bool is_stress, bool is_ours_alone, int strokes,
        const std::string& output) {
  std::vector<Human> humans;
  for (const std::string& file : files) humans.push_back(read_human(file));
  AtomicFolder folder(output);
  std::vector<RobotPoint> points;
  if (is_stress)
    stress(humans, strokes, points);
  else
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
  std::string output;
  int strokes = 20;
  bool is_stress = false, is_ours_alone = false;
  app.add_option("SCAN", scans, "x.obj with x.labels.txt beside it")->required();
  app.add_option("--strokes", strokes, "strokes a scan")->check(CLI::Range(1, 200));
  app.add_flag("--stress", is_stress, "ours alone, under wrong strokes, noise and blur");
  app.add_flag("--ours", is_ours_alone, "without the simpler ways");
  app.add_option("-o,--output", output, "folder for chart.csv, .svg and .png")->required();
  CLI11_PARSE(app, argc, argv);
  try {
    return ohb::run(scans, is_stress, is_ours_alone, strokes, output);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "label_robot: %s\n", error.what());
    return 2;
  }
}
