#include "tests/bench/robot_chart.h"

#include <fmt/format.h>

#include <algorithm>

#include "dataset/model/atomic_file.h"
#include "dataset/model/error.h"
#include "dataset/model/process.h"

namespace ohb {
namespace {

std::vector<std::string> series_of(const std::vector<RobotPoint>& points) {
  std::vector<std::string> names;
  for (const RobotPoint& p : points)
    if (std::find(names.begin(), names.end(), p.series) == names.end()) names.push_back(p.series);
  return names;
}

/// Over the scans of one series after that many strokes, sorted; empty if there are none.
std::vector<double> values_at(const std::vector<RobotPoint>& points, const std::string& series, int strokes,
                              double RobotPoint::*value) {
  std::vector<double> values;
  for (const RobotPoint& p : points)
    if (p.series == series && p.strokes == strokes) values.push_back(p.*value);
  std::sort(values.begin(), values.end());
  return values;
}

double median(const std::vector<double>& sorted) {
  return 0.5 * (sorted[(sorted.size() - 1) / 2] + sorted[sorted.size() / 2]);
}

int most_strokes(const std::vector<RobotPoint>& points) {
  int most = 0;
  for (const RobotPoint& p : points) most = std::max(most, p.strokes);
  return most;
}

std::string plot_script(const std::vector<RobotPoint>& points) {
  constexpr double kLeastError_percent = 0.01;
  const std::vector<std::string> names = series_of(points);
  std::string script;
  for (size_t s = 0; s < names.size(); ++s) {
    script += fmt::format("$s{} << EOD\n", s);
    for (int n = 0; n <= most_strokes(points); ++n)
      script +=
          fmt::format("{} {:.5g} {:.5g}\n", n,
                      std::max(kLeastError_percent,
                               100 * (1 - median(values_at(points, names[s], n, &RobotPoint::accuracy)))),
                      median(values_at(points, names[s], n, &RobotPoint::worst_iou)));
    script += "EOD\n";
  }
  const char* const colours[] = {"#1f5fbf", "#c03030", "#b36b00", "#1a7f37", "#7a3fa0", "#555555", "#00838f"};
  const auto lines = [&](int column) {
    std::string plot;
    for (size_t s = 0; s < names.size(); ++s) {
      const bool is_noisy = names[s].find(", noisy") != std::string::npos;
      const bool in_pairs = names.size() > 7;  // more series than colours: two share one
      plot += fmt::format("{}$s{} using 1:{} with lines lw 2 dt {} lc rgb '{}' title '{}'",
                          s ? ", \\\n  " : "plot ", s, column, is_noisy || (in_pairs && s % 2) ? 2 : 1,
                          colours[(in_pairs ? s / 2 : s) % 7], names[s]);
    }
    return plot + "\n";
  };
  const std::string panels =
      "set multiplot layout 1,2\nset grid lc rgb '#dddddd'\nset xlabel 'strokes'\nset key font ',9'\n"
      "set logscale y\nset yrange [0.009:100]\nset ylabel 'area labelled wrong, % (median; 0.01: none)'\n"
      "set key outside bottom center maxcols 2\n" +
      lines(2) +
      "unset logscale y\nset yrange [0:1.02]\nset ylabel 'IoU of the worst class (median)'\nset key bottom "
      "right\n" +
      lines(3) + "unset multiplot\n";
  script += "set terminal svg size 1300,560 background rgb 'white'\nset output 'chart.svg'\n" + panels;
  script += "set terminal pngcairo size 1300,560\nset output 'chart.png'\n" + panels;
  return script;
}

}  // namespace

std::string robot_csv(const std::vector<RobotPoint>& points) {
  std::string csv = "series,scan,strokes,accuracy,worst_iou,wall_s,cpu_s\n";
  for (const RobotPoint& p : points)
    csv += fmt::format("\"{}\",{},{},{:.6f},{:.6f},{:.4f},{:.4f}\n", p.series, p.scan, p.strokes, p.accuracy,
                       p.worst_iou, p.wall_s, p.cpu_s);
  return csv;
}

std::string robot_table(const std::vector<RobotPoint>& points) {
  std::string table = fmt::format("{:<34}", "median / least accuracy in %, IoU");
  for (const int n : {0, 1, 2, 4, 8, 20}) table += fmt::format("{:>25}", fmt::format("{} strokes", n));
  table += fmt::format("{:>26}\n", "cpu s, wall s of a stroke");
  for (const std::string& name : series_of(points)) {
    table += fmt::format("{:<34}", name);
    for (const int n : {0, 1, 2, 4, 8, 20}) {
      const auto accuracy = values_at(points, name, n, &RobotPoint::accuracy);
      const auto iou = values_at(points, name, n, &RobotPoint::worst_iou);
      if (accuracy.empty()) continue;
      table += fmt::format("{:>25}", fmt::format("{:.2f}/{:.2f} {:.2f}/{:.2f}", 100 * median(accuracy),
                                                 100 * accuracy.front(), median(iou), iou.front()));
    }
    std::vector<double> cpu_s, wall_s;
    for (const RobotPoint& p : points) {
      if (p.series != name || !(p.cpu_s > 0)) continue;
      cpu_s.push_back(p.cpu_s);
      wall_s.push_back(p.wall_s);
    }
    std::sort(cpu_s.begin(), cpu_s.end());
    std::sort(wall_s.begin(), wall_s.end());
    if (!cpu_s.empty())
      table += fmt::format("  {:.3f}/{:.3f} {:.3f}/{:.3f}", median(cpu_s), cpu_s.back(), median(wall_s),
                           wall_s.back());
    table += '\n';
  }
  return table;
}

void draw_robot_chart(const std::vector<RobotPoint>& points, const std::filesystem::path& folder) {
  write_file_atomically(folder / "chart.gp", plot_script(points));
  const std::filesystem::path there = std::filesystem::absolute(folder);
  const ProcessResult result =
      run_process({"gnuplot", "-e", "cd '" + there.string() + "'", (there / "chart.gp").string()}, {},
                  [](const std::string&) {});
  if (result.exit_code != 0)
    throw InputError("gnuplot", "chart.gp", "failed", "install gnuplot-nox 5.4 or later");
}

}  // namespace ohb
