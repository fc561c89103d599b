// What the catalogues of hard cases share, of renders (stress.h) and of bakes (bake_stress.h): a case and its
// points, how they are read, judged and reported.
#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "dataset/model/json_catalogue.h"
#include "renderer/validation/gnuplot.h"

namespace ohb::studies {

/// One value of a case's parameter. `Acceptance`: what its measurements must keep.
template <class Acceptance>
struct HardPoint {
  using Accepts = Acceptance;
  double at = 0;
  Acceptance accept;
  std::string why;  // the point's own acceptance, if it differs from its case's
};

/// `Point`: a HardPoint.
template <class Point>
struct HardCase {
  std::string name, scene, what, parameter, acceptable;
  bool log_scale = false;
  std::vector<Point> points;
};

/// `Result`: `point`, what was measured there, and `failures`: what is not acceptable, with the figures.
template <class Case, class Result>
struct HardCaseResult {
  Case stress;
  std::vector<Result> results;

  bool passes() const {
    for (const Result& result : results)
      if (!result.failures.empty()) return false;
    return true;
  }
};

/// A case of a catalogue, for read_json_catalogue. A point is its value, or an object with the value in "at"
/// and, where it differs from the case's, "accept" with "why". `acceptance_of(json, base)`: what the JSON
/// states in place of the base's; `read_more(json, point)`: what else a point's object says.
template <class Point, class AcceptanceOf, class ReadMore>
HardCase<Point> read_hard_case(const nlohmann::json& from, const AcceptanceOf& acceptance_of,
                               const ReadMore& read_more) {
  HardCase<Point> stress;
  stress.name = from.at("name");
  stress.scene = from.at("scene");
  stress.what = from.at("what");
  stress.parameter = from.at("parameter");
  stress.acceptable = from.at("acceptable");
  stress.log_scale = from.value("log", false);
  const typename Point::Accepts base = acceptance_of(from.at("accept"), {});
  for (const nlohmann::json& each : from.at("points")) {
    Point point;
    point.accept = base;
    point.at = each.is_number() ? each : each.at("at");
    if (each.is_object()) read_more(each, point);
    if (each.is_object() && each.contains("accept")) {
      point.accept = acceptance_of(each.at("accept"), base);
      point.why = each.at("why");
    }
    stress.points.push_back(point);
  }
  if (stress.points.empty()) throw InputError("", "points", "there are none", "give one at least");
  return stress;
}

/// chart.json. `point_json(result)`: an object of `Json` with what was measured.
template <class Json, class CaseResult, class PointJson>
std::string hard_cases_json(const std::vector<CaseResult>& results, const PointJson& point_json) {
  Json json = {{"cases", Json::array()}};
  bool passes = true;
  for (const CaseResult& c : results) {
    passes = passes && c.passes();
    Json points = Json::array();
    for (const auto& result : c.results) points.push_back(point_json(result));
    json["cases"].push_back({{"name", c.stress.name},
                             {"what", c.stress.what},
                             {"parameter", c.stress.parameter},
                             {"acceptable", c.stress.acceptable},
                             {"passes", c.passes()},
                             {"points", points}});
  }
  json["passes"] = passes;
  return json_text(json, 2) + "\n";
}

/// The lines of a panel before its plot: the axis of the parameter, with numbers as gnuplot's `log_format` on
/// a logarithmic one, and the case's name and verdict.
template <class CaseResult>
std::string panel_head(const CaseResult& result, const std::string& log_format) {
  std::string script = result.stress.log_scale ? "set logscale x\nset format x '" + log_format + "'\n"
                                               : "unset logscale x\nset format x '%g'\n";
  script += "set xlabel " + validation::gnuplot_quoted(result.stress.parameter) + " noenhanced\n";
  return script + fmt::format("set title {} noenhanced tc rgb '{}'\n",
                              validation::gnuplot_quoted(
                                  result.stress.name +
                                  (result.passes() ? ": within its limits" : ": NOT WITHIN ITS LIMITS")),
                              result.passes() ? "#1a7f37" : "#c03030");
}

/// Where a point stands on the axis: a logarithmic one has no 0, which is drawn a decade below the smallest.
template <class CaseResult>
double place_of(const CaseResult& of_case, double at) {
  if (!of_case.stress.log_scale || at > 0) return at;
  double least = 1e300;
  for (const auto& result : of_case.results)
    if (result.point.at > 0) least = std::min(least, result.point.at);
  return least / 10;
}

/// The verdict of each case and what fails, on stdout, then where the chart is.
template <class CaseResult>
void print_hard_cases(const std::vector<CaseResult>& results, const std::filesystem::path& chart) {
  for (const CaseResult& c : results) {
    std::printf("%-28s %s\n", c.stress.name.c_str(),
                c.passes() ? "within its limits" : "NOT WITHIN ITS LIMITS");
    for (const auto& result : c.results)
      for (const std::string& failure : result.failures)
        std::printf("    %s %g: %s\n", c.stress.parameter.c_str(), result.point.at, failure.c_str());
  }
  std::printf("%s\n", chart.c_str());
}

}  // namespace ohb::studies
