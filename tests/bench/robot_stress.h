// Wrong strokes and damaged pictures, from harmless to impossible, with what is acceptable
// (assets/stress/label_catalogue.json).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tests/bench/robot_run.h"

namespace ohb {
using namespace labelling;
using namespace surface;

enum class RobotDamage { kWrongStrokes, kPictureNoise, kPictureBlur };

struct RobotStressPoint {
  double at = 0;
  double median = 0,
         least = 0;  // of the right share of the area over the scans after the last stroke, at least
  std::string why;   // the point's own limits, if they differ from its case's
};

struct RobotStressCase {
  std::string name, parameter, acceptable;
  RobotDamage damage = RobotDamage::kWrongStrokes;
  std::vector<RobotStressPoint> points;
};

/// Throws InputError with the case that is wrong.
std::vector<RobotStressCase> read_robot_stress(const std::filesystem::path& file);

/// One point of one case. Right shares of the area, without a stroke and after the last.
struct RobotStressResult {
  RobotStressCase stress;
  RobotStressPoint point;
  double start_median = 0, median = 0, least = 0;
  std::string failure;  // what is below its limit; empty: acceptable
};
std::vector<RobotStressResult> run_robot_stress(const std::vector<RobotStressCase>& cases,
                                                const std::vector<RobotHuman>& humans, int strokes);

std::string robot_stress_text(const std::vector<RobotStressResult>& results);
std::string robot_stress_csv(const std::vector<RobotStressResult>& results);

/// chart.svg and chart.png: a panel a case. Throws as run_gnuplot.
void draw_robot_stress(const std::vector<RobotStressResult>& results, const std::filesystem::path& folder);

}  // namespace ohb
