#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "dataset/model/json_text.h"
#include "dataset/studies/speed_accuracy.h"
#include "renderer/validation/gnuplot.h"

namespace ohb::studies {
namespace fs = std::filesystem;
namespace {

std::vector<std::string> series_of(const SpeedAccuracy& chart) {
  std::vector<std::string> names;
  for (const SpeedAccuracyPoint& p : chart.points)
    if (std::find(names.begin(), names.end(), p.series) == names.end()) names.push_back(p.series);
  return names;
}

/// Marks at 1, 2 and 5 of every decade: gnuplot's own are one a decade, which a short axis has none of.
std::string tics(const char* axis) {
  std::string list;
  for (int decade = -4; decade <= 4; ++decade)
    for (const int digit : {1, 2, 5})
      list += fmt::format("{}'{:g}' {}e{}", list.empty() ? "" : ", ", digit * std::pow(10.0, decade), digit,
                          decade);
  return fmt::format("set {}tics ({})\n", axis, list);
}

/// The points of each series, and the Pareto front.
std::string data_blocks(const SpeedAccuracy& chart, const std::vector<std::string>& names) {
  std::string script;
  for (size_t s = 0; s < names.size(); ++s) {
    script += fmt::format("$s{} << EOD\n", s);
    for (const SpeedAccuracyPoint& p : chart.points)
      if (p.series == names[s])
        script += fmt::format("{:.6g} {:.6g}\n", p.load_s + p.wall_s, 100 * p.relative_error);
    script += "EOD\n";
  }
  script += "$front << EOD\n";
  for (const SpeedAccuracyPoint& p : chart.points)
    if (p.on_front) script += fmt::format("{:.6g} {:.6g}\n", p.load_s + p.wall_s, 100 * p.relative_error);
  script += "EOD\n";
  return script;
}

const char* colour_of(const std::string& series) {
  const bool ours = series.rfind("ours", 0) == 0;
  const bool plain = series.find("no subsurface") != std::string::npos;
  const bool several = series.find("lights") != std::string::npos;
  if (series == "ours, auto") return "#7a3fb0";
  if (series == "ours, fast") return "#c77fd9";
  if (ours) return several ? "#1a7f37" : plain ? "#5fa8e8" : "#1f5fbf";
  return plain ? "#f08a80" : several ? "#b36b00" : "#c03030";
}

/// The line of the plot that draws all series.
std::string plot_command(const std::vector<std::string>& names) {
  std::string plot = "plot $front with points pt 6 ps 2 lc rgb '#999999' title 'Pareto front', \\\n";
  for (size_t s = 0; s < names.size(); ++s) {
    const bool several = names[s].find("lights") != std::string::npos;
    plot +=
        fmt::format("  $s{} with linespoints pt {} lw 2 dt {} lc rgb '{}' title {}{}\n", s, several ? 5 : 7,
                    names[s].find("adaptive") != std::string::npos ? 3 : 1, colour_of(names[s]),
                    validation::gnuplot_quoted(names[s]), s + 1 < names.size() ? ", \\" : "");
  }
  return plot;
}

std::string plot_script(const SpeedAccuracy& chart) {
  const std::vector<std::string> names = series_of(chart);
  std::string script = data_blocks(chart, names);
  script +=
      "set logscale xy\nset autoscale noextend\nset offsets graph 0.05, graph 0.05, graph 0.05, graph "
      "0.05\nset grid\nset key outside right top\n";
  script += tics("x") + tics("y");
  script += "set xlabel 'seconds of one image (of all its lights), loading included'\n";
  script += "set ylabel 'error: root mean square, % of the picture'\n";
  script += "set title " +
            validation::gnuplot_quoted(fmt::format("{} in {}, {} x {} px; 4, 16, ... paths a pixel",
                                                   chart.model_name, chart.environments.front(),
                                                   chart.settings.size_px, chart.settings.size_px)) +
            " noenhanced\n";
  const std::string plot = plot_command(names);
  script += "set terminal svg size 980,560 background rgb 'white'\nset output 'chart.svg'\n" + plot;
  script += "set terminal pngcairo size 980,560\nset output 'chart.png'\n" + plot;
  return script;
}

}  // namespace

std::string speed_accuracy_csv(const SpeedAccuracy& chart) {
  std::string csv = "series,spp,adaptive_threshold,load_s,wall_s,cpu_s,relative_error,on_front\n";
  for (const SpeedAccuracyPoint& p : chart.points)
    csv += fmt::format("\"{}\",{},{},{:.4f},{:.4f},{:.4f},{:.6g},{}\n", p.series, p.spp, p.adaptive_threshold,
                       p.load_s, p.wall_s, p.cpu_s, p.relative_error, p.on_front ? 1 : 0);
  return csv;
}

std::string speed_accuracy_json(const SpeedAccuracy& chart) {
  nlohmann::json json = {{"model", chart.model_name},
                         {"blender", chart.blender_version},
                         {"environments", chart.environments},
                         {"size_px", chart.settings.size_px},
                         {"seeds", chart.settings.seeds},
                         {"threads", chart.settings.threads},
                         {"subsurface_effect", chart.subsurface_effect}};
  for (const SpeedAccuracyPoint& p : chart.points)
    json["points"].push_back({{"series", p.series},
                              {"spp", p.spp},
                              {"adaptive_threshold", p.adaptive_threshold},
                              {"load_s", p.load_s},
                              {"wall_s", p.wall_s},
                              {"cpu_s", p.cpu_s},
                              {"relative_error", p.relative_error},
                              {"on_front", p.on_front}});
  for (const SpeedAccuracyRatio& r : chart.ratios)
    json["times_to_equal_error"].push_back({{"ours", r.ours},
                                            {"cycles", r.cycles},
                                            {"cycles_adaptive_threshold", r.adaptive_threshold},
                                            {"relative_error", r.relative_error},
                                            {"cycles_over_ours", r.with_loading},
                                            {"cycles_over_ours_without_loading", r.without_loading}});
  return json_text(json, 2) + "\n";
}

void draw_speed_accuracy(const SpeedAccuracy& chart, const fs::path& folder) {
  validation::run_gnuplot(plot_script(chart), folder);
}

}  // namespace ohb::studies
