#include "tests/bench/robot_run.h"

#include <algorithm>
#include <random>

#include "dataset/commands/label.h"
#include "dataset/model/scan_unit.h"
#include "dataset/model/stopwatch.h"

namespace ohb {
using namespace commands;
using namespace labelling;
using namespace surface;
RobotHuman read_robot_human(const std::filesystem::path& file) {
  RobotHuman human{file.stem().string(), read_scan(file), {}, {}, file};
  std::filesystem::path labels = file;
  labels.replace_extension(".labels.txt");
  human.truth = read_face_classes(labels, human.scan.face_count(), class_order_of(labels, file));
  human.area = face_areas(human.scan);
  return human;
}

void run_robot(const RobotHuman& human, const std::string& series, const RobotMethod& method,
               const RobotNoise& noise, int count, std::vector<RobotPoint>& points) {
  Labeller labeller({human.scan, guess_unit(human.scan).unit_cm.value_or(1)}, method.terms);
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
      const Stopwatch watch;
      face_class = method.nearest ? nearest_stroke_classes(graph, labeller.unit_cm(), strokes, start)
                                  : labeller.solve(strokes).face_class;
      point.cpu_s = watch.cpu_s();
      point.wall_s = watch.wall_s();
    }
    const TruthComparison truth = compare_with_truth(face_class, human.truth, human.area);
    point.strokes = n;
    point.accuracy = truth.accuracy;
    point.worst_iou = 1;
    for (const auto& iou : truth.iou) point.worst_iou = std::min(point.worst_iou, iou.value_or(1));
    points.push_back(point);
  }
}

}  // namespace ohb
