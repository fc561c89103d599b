#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "dataset/studies/stress.h"

namespace ohb::studies {
namespace {

nlohmann::json side_json(const StressSide& side) {
  if (!side.is_there) return nullptr;
  return {{"mean_radiance", side.mean},
          {"standard_error", side.standard_error},
          {"load_s", side.load_s},
          {"processor_us_a_path", side.cpu_us_a_path}};
}

/// Columns: x, brightness of ours and of Cycles over the first of ours with three standard errors, time a
/// path of both.
std::string data_of(const StressCaseResult& result, size_t number) {
  const double first = result.results.empty() ? 1 : result.results.front().ours.mean;
  std::string data = fmt::format("$c{} << EOD\n", number);
  std::vector<StressResult> along_x = result.results;  // the catalogue begins with the harmless one
  std::stable_sort(along_x.begin(), along_x.end(),
                   [](const StressResult& a, const StressResult& b) { return a.point.at < b.point.at; });
  for (const StressResult& r : along_x) {
    const auto brightness = [&](const StressSide& side) {
      return side.is_there && std::isfinite(side.mean)
                 ? fmt::format("{:.6g} {:.6g}", side.mean / first, 3 * side.standard_error / first)
                 : std::string("NaN NaN");
    };
    data += fmt::format("{:.6g} {} {} {:.6g} {}\n", place_of(result, r.point.at), brightness(r.ours),
                        brightness(r.cycles), r.ours.cpu_us_a_path,
                        r.cycles.is_there ? fmt::format("{:.6g}", r.cycles.cpu_us_a_path) : "NaN");
  }
  return data + "EOD\n";
}

/// Brightness and time.
std::array<std::string, 2> panels_of(const StressCaseResult& result, size_t number) {
  std::string script =
      panel_head(result, "10^{%L}") + "unset logscale y\nset ylabel 'light, first of ours = 1'\n";
  script += fmt::format(
      "plot $c{0} using 1:4:5 with yerrorlines pt 4 ps 1.2 lw 1 lc rgb '#c03030' title 'Cycles', $c{0} using "
      "1:2:3 "
      "with yerrorlines pt 7 ps 0.6 lw 2 lc rgb '#1f5fbf' title 'ours'\n",
      number);
  std::string time = "set logscale y\nset ylabel 'processor us a path'\nset title " +
                     validation::gnuplot_quoted(result.stress.what) + " noenhanced tc rgb '#555555'\n";
  time += fmt::format(
      "plot $c{0} using 1:7 with linespoints pt 4 ps 1.2 lw 1 lc rgb '#c03030' notitle, $c{0} using 1:6 with "
      "linespoints pt 7 ps 0.6 lw 2 lc rgb '#1f5fbf' notitle\n",
      number);
  return {script, time};
}

}  // namespace

std::string stress_csv(const std::vector<StressCaseResult>& results) {
  std::string csv =
      "case,parameter,at,ours_mean,ours_standard_error,cycles_mean,cycles_standard_error,ours_load_s,"
      "ours_us_a_path,cycles_us_a_path,leaks,nonfinite_a_path,nan_pixels,failures\n";
  const auto number = [](const StressSide& side, double value) {
    return side.is_there ? fmt::format("{:.6g}", value) : std::string();
  };
  for (const StressCaseResult& c : results)
    for (const StressResult& r : c.results) {
      std::string failures;
      for (const std::string& failure : r.failures) failures += (failures.empty() ? "" : "; ") + failure;
      csv += fmt::format("\"{}\",\"{}\",{:.6g},{},{},{},{},{:.3f},{},{},{:.3g},{:.3g},{},\"{}\"\n",
                         c.stress.name, c.stress.parameter, r.point.at, number(r.ours, r.ours.mean),
                         number(r.ours, r.ours.standard_error), number(r.cycles, r.cycles.mean),
                         number(r.cycles, r.cycles.standard_error), r.ours.load_s,
                         number(r.ours, r.ours.cpu_us_a_path), number(r.cycles, r.cycles.cpu_us_a_path),
                         r.leaks, r.nonfinite_share, r.nan_pixels, failures);
    }
  return csv;
}

std::string stress_json(const std::vector<StressCaseResult>& results) {
  return hard_cases_json<nlohmann::json>(results, [](const StressResult& r) {
    return nlohmann::json{{"at", r.point.at},
                          {"ours", side_json(r.ours)},
                          {"cycles", side_json(r.cycles)},
                          {"walk_leaks", r.leaks},
                          {"nonfinite_a_path", r.nonfinite_share},
                          {"nan_pixels", r.nan_pixels},
                          {"failures", r.failures}};
  });
}

void draw_stress(const std::vector<StressCaseResult>& results, const std::filesystem::path& folder) {
  std::string script;
  std::vector<std::string> panels;
  for (size_t i = 0; i < results.size(); ++i) {
    script += data_of(results[i], i);
    for (std::string& panel : panels_of(results[i], i)) panels.push_back(std::move(panel));
  }
  script +=
      "set grid\nset key outside right top\nset offsets graph 0.05, graph 0.05, graph 0.15, graph 0.15\n";
  validation::draw_panels(script, panels, 2, 1100, 260, folder);
}

}  // namespace ohb::studies
