#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "dataset/model/json_text.h"
#include "dataset/studies/bake_fidelity.h"
#include "renderer/validation/gnuplot.h"

namespace ohb::studies {
namespace {

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : "; ") + word;
  return text;
}

nlohmann::ordered_json interval_json(const validation::Interval& interval) {
  return {{"ratio", interval.value}, {"low", interval.low}, {"high", interval.high}};
}

nlohmann::ordered_json point_json(const FidelityPoint& p) {
  nlohmann::ordered_json regions = nlohmann::ordered_json::array();
  for (const validation::RegionRatio& region : p.regions)
    regions.push_back({{"name", region.name}, {"pixels", region.weight_px}, {"ratio", region.total.value}});
  return {{"map_px", p.map_px},
          {"own_size", p.is_own_size},
          {"relative_error", p.relative_error},
          {"bins", p.bins.bins},
          {"bins_accepted", p.bins.accepted},
          {"tests_below_5_percent", p.bins.below_5_percent},
          {"median_detectable", p.bins.median_detectable},
          {"whole_image_own_seeds", interval_json(p.whole.total)},
          {"regions_shared_seeds", regions},
          {"bake_processor_s", p.bake_cpu_s},
          {"failures", p.failures}};
}

/// In words: at which size the maps begin to differ.
std::string where_it_fails(const BakeFidelity& fidelity) {
  for (const FidelityPoint& p : fidelity.points)
    if (!p.failures.empty())
      return fmt::format("maps of {} px are the largest that differ: {}", p.map_px, joined(p.failures));
  return fmt::format("no size differs, down to {} px",
                     fidelity.points.empty() ? 0 : fidelity.points.back().map_px);
}

/// Columns: map size, error in percent, rejected bins in percent, processor seconds, within its limits.
std::string data_of(const BakeFidelity& fidelity) {
  constexpr double kLeast_percent = 1e-3;  // a logarithmic axis has no 0
  std::string data = "$points << EOD\n";
  for (const FidelityPoint& p : fidelity.points)
    data += fmt::format("{} {:.6g} {:.6g} {:.6g} {}\n", p.map_px,
                        std::max(kLeast_percent, 100 * p.relative_error),
                        std::max(kLeast_percent, 100 * (1 - p.bins.accepted_share)), p.bake_cpu_s,
                        p.failures.empty() ? 1 : 0);
  return data + "EOD\n";
}

}  // namespace

std::string fidelity_text(const BakeFidelity& fidelity) {
  std::string text =
      fmt::format("{:>8} {:>11} {:>20} {:>24} {:>11}  {}\n", "map px", "error", "bins accepted",
                  "baked / source - 1, 95 %", "bake cpu s", "within the limits");
  for (const FidelityPoint& p : fidelity.points)
    text += fmt::format("{:>8} {:>9.3f} % {:>20} {:>24} {:>11.2f}  {}\n", p.map_px, 100 * p.relative_error,
                        fmt::format("{:.2f} % of {}", 100 * p.bins.accepted_share, p.bins.bins),
                        fmt::format("{:+.3f} [{:+.3f}, {:+.3f}] %", 100 * (p.whole.total.value - 1),
                                    100 * (p.whole.total.low - 1), 100 * (p.whole.total.high - 1)),
                        p.bake_cpu_s, p.failures.empty() ? "yes" : joined(p.failures));
  const FidelityThresholds& limits = fidelity.settings.thresholds;
  text += fmt::format(
      "{}: {}\n{}: maps of the pictures' size ({} px) and larger {} the scan's own materials"
      " ({:.1f} % of the bins; the mean within {:.1f} %, of each class {:.1f} %)\n",
      fidelity.scan, where_it_fails(fidelity), fidelity.passes() ? "pass" : "difference", fidelity.picture_px,
      fidelity.passes() ? "render as" : "DO NOT RENDER AS", 100 * limits.accepted_share, 100 * limits.ratio,
      100 * limits.class_ratio);
  return text;
}

std::string fidelity_csv(const BakeFidelity& fidelity) {
  std::string csv =
      "map_px,own_size,relative_error,bins,bins_accepted,ratio,ratio_low,ratio_high,bake_processor_s,"
      "failures\n";
  for (const FidelityPoint& p : fidelity.points)
    csv += fmt::format("{},{},{:.6g},{},{},{:.6g},{:.6g},{:.6g},{:.3f},\"{}\"\n", p.map_px,
                       p.is_own_size ? 1 : 0, p.relative_error, p.bins.bins, p.bins.accepted,
                       p.whole.total.value, p.whole.total.low, p.whole.total.high, p.bake_cpu_s,
                       joined(p.failures));
  return csv;
}

std::string fidelity_json(const BakeFidelity& fidelity) {
  const FidelitySettings& settings = fidelity.settings;
  nlohmann::ordered_json json = {{"scan", fidelity.scan},
                                 {"environment", fidelity.environment},
                                 {"borders", fidelity.has_soft_borders ? "soft" : "hard"},
                                 {"picture_px", fidelity.picture_px},
                                 {"view", fmt::format("{}/{}", settings.view, settings.view_count)},
                                 {"size_px", settings.size_px},
                                 {"spp", settings.spp},
                                 {"seeds", settings.seeds},
                                 {"seed", settings.seed},
                                 {"thresholds",
                                  {{"accepted_share", settings.thresholds.accepted_share},
                                   {"ratio", settings.thresholds.ratio},
                                   {"class_ratio", settings.thresholds.class_ratio}}},
                                 {"points", nlohmann::ordered_json::array()},
                                 {"words", where_it_fails(fidelity)},
                                 {"passes", fidelity.passes()}};
  for (const FidelityPoint& p : fidelity.points) json["points"].push_back(point_json(p));
  return json_text(json, 2) + "\n";
}

void draw_fidelity(const BakeFidelity& fidelity, const std::filesystem::path& folder) {
  std::string script = data_of(fidelity);
  const std::string panels =
      "set multiplot layout 1,2 title " +
      validation::gnuplot_quoted(fidelity.scan + ": baked maps beside its own materials") +
      " noenhanced\nset grid lc rgb '#dddddd'\nset logscale xy\nset xtics () \nset for [i=1:|xs|] xtics add "
      "(sprintf('%d', xs[i]) xs[i])\n"
      "set xlabel 'texels along the maps edge'\nset ylabel 'percent (0.001: none)'\nset key top right\n"
      "set offsets graph 0.08, graph 0.08, graph 0.1, graph 0.15\n" +
      fmt::format("set arrow 1 from {0}, graph 0 to {0}, graph 1 nohead dt 3 lc rgb '#555555'\n",
                  fidelity.picture_px) +
      "plot $points using 1:2 with linespoints pt 7 lw 2 lc rgb '#1f5fbf' title 'error of a pixel', "
      "$points using 1:3 with linespoints pt 4 lw 2 lc rgb '#c03030' title 'bins that differ', "
      "$points using 1:($5 > 0 ? $2 : NaN) with points pt 6 ps 2.2 lw 2 lc rgb '#1a7f37' title 'within its "
      "limits'\n"
      "unset arrow 1\nset xtics autofreq\nset xlabel 'processor seconds of the bake'\nset ylabel 'error of a "
      "pixel, percent'\n"
      "plot $points using 4:2 with linespoints pt 7 lw 2 lc rgb '#1f5fbf' notitle, $points using 4:2:1 with "
      "labels offset 0,1 notitle\nunset multiplot\n";
  std::string sizes;
  for (const FidelityPoint& p : fidelity.points)
    sizes += fmt::format("{}{}", sizes.empty() ? "" : ", ", p.map_px);
  script += fmt::format("array xs[{}] = [{}]\n", fidelity.points.size(), sizes);
  script += "set terminal svg size 1200,480 background rgb 'white'\nset output 'chart.svg'\n" + panels;
  script += "set terminal pngcairo size 1200,480\nset output 'chart.png'\n" + panels;
  validation::run_gnuplot(script, folder);
}

}  // namespace ohb::studies
