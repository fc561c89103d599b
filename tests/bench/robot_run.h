// One robot user on one scan: strokes, solves, and how much of the area is right after each.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dataset/labelling/labeller.h"
#include "tests/bench/robot_chart.h"
#include "tests/bench/robot_user.h"

namespace ohb {
using namespace labelling;
using namespace surface;

struct RobotHuman {
  std::string name;
  Scan scan;
  std::vector<uint8_t> truth;
  std::vector<double> area;
  std::filesystem::path file;
};

/// x.obj with x.labels.txt beside it. Throws as read_scan and read_face_classes.
RobotHuman read_robot_human(const std::filesystem::path& file);

/// One way to label. `nearest`: the class of the nearest stroke, nothing else.
struct RobotMethod {
  const char* name;
  LabelTerms terms;
  bool nearest = false;
};

/// Paints up to `count` strokes, each on what is then most wrong; adds a point for each.
void run_robot(const RobotHuman& human, const std::string& series, const RobotMethod& method,
               const RobotNoise& noise, int count, std::vector<RobotPoint>& points);

}  // namespace ohb
