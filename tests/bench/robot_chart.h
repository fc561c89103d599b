// What the robot measured, as a table, a file and a chart.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace ohb {

/// One scan of one series after that many strokes. Shares of the area; seconds of the last re-solve.
struct RobotPoint {
  std::string series, scan;
  int strokes = 0;
  double accuracy = 0, worst_iou = 0;  // worst_iou: of the classes that occur
  double wall_s = 0, cpu_s = 0;
};

std::string robot_csv(const std::vector<RobotPoint>& points);

/// Median and least over the scans at 0, 1, 2, 4, 8 and 20 strokes, and median and worst seconds of a stroke,
/// a line a series.
std::string robot_table(const std::vector<RobotPoint>& points);

/// Draws chart.svg and chart.png (median error and worst class's IoU against strokes) and keeps chart.gp.
/// Throws InputError if gnuplot is missing or fails.
void draw_robot_chart(const std::vector<RobotPoint>& points, const std::filesystem::path& folder);

}  // namespace ohb
