// What `stress` prints, writes and draws.
#include <fmt/format.h>

#include <cmath>

#include "learner/stress.h"
#include "renderer/validation/gnuplot.h"

namespace ohb::learner {
namespace {

using nlohmann::json;

constexpr size_t kAlbedo = 1;  // of kColumns

std::string levels_text(const std::vector<double>& levels) {
  std::string text;
  for (const double level : levels) text += fmt::format("{}{:g}", text.empty() ? "" : ", ", level);
  return text;
}

/// Columns: level, seconds, albedo, input as albedo, angle of normals, baked in, change, IoU in %.
std::string data_of(const StressSeries& series, size_t number) {
  std::string data = fmt::format("$s{} << EOD\n", number);
  for (const StressLevel& l : series.levels)
    data += fmt::format("{:g} {:.6g} {:.6g} {:.6g} {:.6g} {:.6g} {:.6g} {:.6g}\n", l.level, l.seconds,
                        l.psnr[kAlbedo].masked, l.input_as_albedo_dB, l.measures[kNormalMean_deg], l.baked_in,
                        l.change, 100 * l.measures[kClassIou]);
  return data + "EOD\n";
}

/// Albedo, normals and materials, and what shading is left in the albedo.
std::vector<std::string> panels_of(const StressSeries& series, size_t number) {
  const auto quoted = [](const std::string& text) {
    return validation::gnuplot_quoted(text) + " noenhanced";
  };
  const std::string axis = fmt::format(
      "unset logscale\nunset label\nset xlabel {}\nset arrow 1 from {:g}, graph 0 to {:g}, graph 1 nohead dt "
      "3 lc rgb '#999999'\n",
      quoted(series.parameter), series.harmless, series.harmless);
  const std::vector<double> broken = series.broken();
  const std::string title =
      series.name +
      (broken.empty() ? ": holds" : fmt::format(": {:g} dB lost at {}", kBroken_dB, levels_text(broken)));
  const std::string line = "with linespoints pt 7 ps 0.6 lw 2";
  return {axis + "set yrange [*:*]\nset ylabel 'albedo, dB'\nset title " + quoted(title) +
              fmt::format(" tc rgb '{}'\n", broken.empty() ? "#1a7f37" : "#c03030") +
              fmt::format("plot $s{0} using 1:4 with lines lw 1 lc rgb '#888888' title 'picture as albedo', "
                          "$s{0} using 1:3 {1} lc rgb '#1f5fbf' title 'estimate'\n",
                          number, line),
          axis + "set yrange [0:*]\nset ylabel 'degrees, %'\nset title 'normals and materials'\n" +
              fmt::format("plot $s{0} using 1:5 {1} lc rgb '#b36b00' title 'normals off by, degrees', $s{0} "
                          "using 1:8 {1} lc "
                          "rgb '#7a3fb0' title 'IoU of materials, %'\n",
                          number, line),
          axis + "set yrange [*:*]\nset ylabel ''\nset title 'albedo: what stays in it, what moves'\n" +
              fmt::format(
                  "plot $s{0} using 1:6 {1} lc rgb '#c03030' title 'correlation with shading', $s{0} using "
                  "1:7 {1} lc rgb '#1a7f37' title 'relative change'\n",
                  number, line)};
}

/// Accuracy against time over the sizes that the networks see.
std::vector<std::string> time_panels(const StressReport& report, size_t number) {
  const auto quoted = [](const std::string& text) {
    return validation::gnuplot_quoted(text) + " noenhanced";
  };
  const std::string axis =
      "unset arrow 1\nset logscale x\nset xlabel 'processor seconds a picture'\n"
      "set title 'accuracy against time: by size'\n";
  std::string labels;
  for (const StressLevel& l : report.series.at(number).levels)
    labels += fmt::format("set label {} at {:.6g}, {:.6g} offset 0.5, -0.7 front\n",
                          quoted(fmt::format("{:g} px", l.level * report.size_px)), l.seconds,
                          l.psnr[kAlbedo].masked);
  return {axis + labels + "set yrange [*:*]\nset ylabel 'albedo, dB'\n" +
              fmt::format("plot $s{} using 2:3 with linespoints pt 7 ps 0.6 lw 2 lc rgb '#1f5fbf' notitle\n",
                          number),
          "unset label\nset yrange [0:*]\nset ylabel 'normals off by, degrees'\n" +
              fmt::format("plot $s{} using 2:5 with linespoints pt 7 ps 0.6 lw 2 lc rgb '#b36b00' notitle\n",
                          number)};
}

}  // namespace

std::string stress_table(const StressReport& report) {
  std::string text = fmt::format(
      "{} people at {} x {}, means; broken: albedo more than {:g} dB below the harmless picture's\n\n"
      "| {:<9} | {:>6} | {:>6} | {:>6} | {:>6} | {:>6} | {:>6} | {:>6} | {:>7} | {:>8} | {:<6} |\n"
      "|-----------|-------:|-------:|-------:|-------:|-------:|-------:|-------:|--------:|---------:|-----"
      "---|\n",
      report.people, report.size_px, report.size_px, kBroken_dB, "kind", "level", "D", "input", "N deg", "R",
      "IoU", "change", "shading", "seconds", "broken");
  for (const StressSeries& s : report.series) {
    const std::vector<double> broken = s.broken();
    for (const StressLevel& l : s.levels) {
      const bool is_broken = std::find(broken.begin(), broken.end(), l.level) != broken.end();
      text += fmt::format("| {:<9} | {:>6g} |{}{}{}{}{}{} {:>7.2f} | {:>8.4f} | {:<6} |\n", s.name, l.level,
                          table_cell(l.psnr[kAlbedo].masked), table_cell(l.input_as_albedo_dB),
                          table_cell(l.measures[kNormalMean_deg]), table_cell(l.psnr[2].masked),
                          table_cell(l.measures[kClassIou]), table_cell(l.change), l.baked_in, l.seconds,
                          l.level == s.harmless ? "-"
                          : is_broken           ? "yes"
                                                : "no");
    }
  }
  return text;
}

std::string stress_csv(const StressReport& report) {
  std::string csv = "kind,parameter,level,pictures";
  for (const char* column : kColumns) csv += fmt::format(",{}_dB", column);
  for (const char* name : kMeasureNames) csv += fmt::format(",{}", name);
  csv += ",input_as_albedo_dB,change,shading_correlation,seconds\n";
  for (const StressSeries& s : report.series)
    for (const StressLevel& l : s.levels) {
      csv += fmt::format("{},\"{}\",{:g},{}", s.name, s.parameter, l.level, l.pictures);
      for (const Psnr& score : l.psnr) csv += fmt::format(",{:.4f}", score.masked);
      for (const double value : l.measures) csv += fmt::format(",{:.4f}", value);
      csv += fmt::format(",{:.4f},{:.4f},{:.4f},{:.4f}\n", l.input_as_albedo_dB, l.change, l.baked_in,
                         l.seconds);
    }
  return csv;
}

json stress_json(const StressReport& report) {
  json out = {{"people", report.people}, {"size_px", report.size_px}, {"kinds", json::array()}};
  for (const StressSeries& s : report.series) {
    json levels = json::array();
    for (const StressLevel& l : s.levels) {
      json level = {{"level", l.level},
                    {"pictures", l.pictures},
                    {"input_as_albedo_dB", json_number(l.input_as_albedo_dB)},
                    {"change", json_number(l.change)},
                    {"shading_correlation", json_number(l.baked_in)},
                    {"seconds", l.seconds}};
      for (size_t i = 0; i < kColumns.size(); ++i) level["dB"][kColumns[i]] = json_number(l.psnr[i].masked);
      for (size_t i = 0; i < kMeasureCount; ++i)
        level["measures"][kMeasureNames[i]] = json_number(l.measures[i]);
      levels.push_back(level);
    }
    out["kinds"].push_back({{"name", s.name},
                            {"parameter", s.parameter},
                            {"harmless", s.harmless},
                            {"broken_at", s.broken()},
                            {"levels", levels}});
  }
  return out;
}

void draw_stress(const StressReport& report, const std::filesystem::path& folder) {
  std::string script;
  std::vector<std::string> panels;
  for (size_t i = 0; i < report.series.size(); ++i) {
    script += data_of(report.series[i], i);
    for (std::string& panel : panels_of(report.series[i], i)) panels.push_back(std::move(panel));
  }
  for (std::string& panel : time_panels(report, report.series.size() - 1)) panels.push_back(std::move(panel));
  script +=
      "set grid\nset key bottom left font ',9'\nset offsets graph 0.04, graph 0.04, graph 0.1, graph 0.15\n";
  validation::draw_panels(script, panels, 3, 1400, 260, folder);
}

}  // namespace ohb::learner
