#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "dataset/studies/bake_stress.h"

namespace ohb::studies {
namespace {

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : "; ") + word;
  std::replace(text.begin(), text.end(), '"', '\'');
  return text;
}

/// Columns: x, normal error in degrees, colour error and wrong share in percent, 1 where it was refused. A
/// logarithmic axis has no 0: that point is drawn a decade below the smallest.
std::string data_of(const BakeStressCaseResult& result, size_t number) {
  constexpr double kLeast = 1e-3;
  std::string data = fmt::format("$c{} << EOD\n", number);
  for (const BakeStressResult& r : result.results) {
    const double x = place_of(result, r.point.at);
    if (!r.refusal.empty())
      data += fmt::format("{:.6g} NaN NaN NaN {}\n", x, kLeast);
    else
      data +=
          fmt::format("{:.6g} {:.6g} {:.6g} {:.6g} NaN\n", x, std::max(kLeast, r.normal_deg),
                      std::max(kLeast, 100 * std::max(r.colour, r.alpha)), std::max(kLeast, 100 * r.wrong));
  }
  return data + "EOD\n";
}

std::string panel(const BakeStressCaseResult& result, size_t number) {
  const auto title = [&](const char* words) {
    return number == 0 ? validation::gnuplot_quoted(words) : "''";
  };
  std::string script = panel_head(result, "%g");
  script += fmt::format(
      "plot $c{0} using 1:2 with linespoints pt 7 ps 0.7 lw 2 lc rgb '#1f5fbf' title {1}, "
      "$c{0} using 1:3 with linespoints pt 5 ps 0.6 lw 2 lc rgb '#b36b00' title {2}, "
      "$c{0} using 1:4 with linespoints pt 9 ps 0.7 lw 1 lc rgb '#7a3fa0' title {3}, "
      "$c{0} using 1:5 with points pt 2 ps 1.4 lw 3 lc rgb '#c03030' title {4}\n",
      number, title("normals, degrees"), title("albedo or cut-out, percent"), title("wrong surface, percent"),
      title("refused"));
  return script;
}

}  // namespace

std::string bake_stress_csv(const std::vector<BakeStressCaseResult>& results) {
  std::string csv =
      "case,parameter,at,normal_deg,colour,alpha,depth_cm,wrong,nonfinite,refusal,warnings,failures\n";
  for (const BakeStressCaseResult& c : results)
    for (const BakeStressResult& r : c.results)
      csv += fmt::format("\"{}\",\"{}\",{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{},\"{}\",\"{}\",\"{}\"\n",
                         c.stress.name, c.stress.parameter, r.point.at, r.normal_deg, r.colour, r.alpha,
                         r.depth_cm, r.wrong, r.nonfinite, joined({r.refusal}), joined(r.warnings),
                         joined(r.failures));
  return csv;
}

std::string bake_stress_json(const std::vector<BakeStressCaseResult>& results) {
  return hard_cases_json<nlohmann::ordered_json>(results, [](const BakeStressResult& r) {
    return nlohmann::ordered_json{{"at", r.point.at},         {"normal_deg", r.normal_deg},
                                  {"colour", r.colour},       {"alpha", r.alpha},
                                  {"depth_cm", r.depth_cm},   {"wrong", r.wrong},
                                  {"nonfinite", r.nonfinite}, {"refusal", r.refusal},
                                  {"warnings", r.warnings},   {"failures", r.failures}};
  });
}

void draw_bake_stress(const std::vector<BakeStressCaseResult>& results, const std::filesystem::path& folder) {
  std::string script;
  std::vector<std::string> panels;
  for (size_t i = 0; i < results.size(); ++i) {
    script += data_of(results[i], i);
    panels.push_back(panel(results[i], i));
  }
  script +=
      "set grid lc rgb '#dddddd'\nset key inside top center maxrows 2 font ',9'\nset logscale y\n"
      "set yrange [0.0008:200]\nset offsets graph 0.05, graph 0.05, 0, 0\n";
  validation::draw_panels(script, panels, 2, 1200, 300, folder);
}

}  // namespace ohb::studies
