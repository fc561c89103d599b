#include "tests/bench/robot_stress.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "dataset/model/atomic_file.h"
#include "dataset/model/error.h"
#include "renderer/validation/gnuplot.h"
#include "tests/bench/damaged_picture.h"

namespace ohb {
using namespace labelling;
using namespace surface;
using namespace validation;
using nlohmann::json;
namespace {

RobotDamage damage_of(const std::string& name) {
  if (name == "wrong strokes") return RobotDamage::kWrongStrokes;
  if (name == "picture noise") return RobotDamage::kPictureNoise;
  if (name == "picture blur") return RobotDamage::kPictureBlur;
  throw InputError("", "damage '" + name + "'", "is not known",
                   "use wrong strokes, picture noise or picture blur");
}

RobotStressCase case_of(const json& from) {
  RobotStressCase stress;
  stress.name = from.at("name");
  stress.damage = damage_of(from.at("damage"));
  stress.parameter = from.at("parameter");
  stress.acceptable = from.at("acceptable");
  for (const json& each : from.at("points")) {
    RobotStressPoint point;
    const json& accept = each.is_number() || !each.contains("accept") ? from.at("accept") : each.at("accept");
    point.at = each.is_number() ? each.get<double>() : each.at("at").get<double>();
    point.median = accept.at("median");
    point.least = accept.at("least");
    if (each.is_object()) point.why = each.at("why");
    stress.points.push_back(point);
  }
  if (stress.points.empty()) throw InputError("", "points", "there are none", "give one at least");
  return stress;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return 0.5 * (values[(values.size() - 1) / 2] + values[values.size() / 2]);
}

RobotStressResult run_point(const RobotStressCase& stress, const RobotStressPoint& point,
                            const std::vector<RobotHuman>& humans, int strokes) {
  std::vector<double> starts, ends;
  for (const RobotHuman& human : humans) {
    RobotHuman damaged = human;
    RobotNoise noise;
    if (stress.damage == RobotDamage::kWrongStrokes) noise.wrong_share = point.at;
    if (stress.damage == RobotDamage::kPictureNoise && point.at > 0) add_noise(damaged.scan, point.at / 255);
    if (stress.damage == RobotDamage::kPictureBlur && point.at > 0)
      blur(damaged.scan, static_cast<int>(point.at) / 2);
    std::vector<RobotPoint> points;
    run_robot(damaged, stress.name, {"ours", {}}, noise, strokes, points);
    starts.push_back(points.front().accuracy);
    ends.push_back(points.back().accuracy);
  }
  RobotStressResult result{
      stress, point, median(starts), median(ends), *std::min_element(ends.begin(), ends.end()), ""};
  if (!(result.median >= point.median && result.least >= point.least))
    result.failure =
        fmt::format("{:.2f} % right, worst {:.2f} % (at least {:g} and {:g})", 100 * result.median,
                    100 * result.least, 100 * point.median, 100 * point.least);
  return result;
}

}  // namespace

std::vector<RobotStressCase> read_robot_stress(const std::filesystem::path& file) {
  std::vector<RobotStressCase> cases;
  std::string place = "the file";
  try {
    const json whole = json::parse(read_file(file));
    for (const json& each : whole.at("cases")) {
      place = fmt::format("case {}", cases.size() + 1);
      cases.push_back(case_of(each));
    }
  } catch (const json::exception& error) {
    throw InputError(file.string(), place, error.what(),
                     "write it as assets/stress/label_catalogue.json is written");
  } catch (const InputError& error) {
    throw InputError(file.string(), place, error.what(), "");
  }
  return cases;
}

std::vector<RobotStressResult> run_robot_stress(const std::vector<RobotStressCase>& cases,
                                                const std::vector<RobotHuman>& humans, int strokes) {
  std::vector<RobotStressResult> results;
  for (const RobotStressCase& stress : cases)
    for (const RobotStressPoint& point : stress.points)
      results.push_back(run_point(stress, point, humans, strokes));
  return results;
}

std::string robot_stress_text(const std::vector<RobotStressResult>& results) {
  std::string text = fmt::format("{:<18}{:>8}{:>12}{:>12}{:>12}  {}\n", "case", "at", "no stroke", "last",
                                 "worst scan", "within its limits");
  for (const RobotStressResult& r : results)
    text += fmt::format("{:<18}{:>8g}{:>10.2f} %{:>10.2f} %{:>10.2f} %  {}\n", r.stress.name, r.point.at,
                        100 * r.start_median, 100 * r.median, 100 * r.least,
                        r.failure.empty() ? "yes" : "NO: " + r.failure);
  return text;
}

std::string robot_stress_csv(const std::vector<RobotStressResult>& results) {
  std::string csv = "case,parameter,at,no_stroke_median,median,least,accept_median,accept_least,failure\n";
  for (const RobotStressResult& r : results)
    csv += fmt::format("\"{}\",\"{}\",{:g},{:.6f},{:.6f},{:.6f},{:g},{:g},\"{}\"\n", r.stress.name,
                       r.stress.parameter, r.point.at, r.start_median, r.median, r.least, r.point.median,
                       r.point.least, r.failure);
  return csv;
}

void draw_robot_stress(const std::vector<RobotStressResult>& results, const std::filesystem::path& folder) {
  constexpr double kLeast_percent = 0.01;  // a logarithmic axis has no 0
  std::string script, panels;
  size_t count = 0;
  for (size_t i = 0; i < results.size(); ++count) {
    const RobotStressCase& stress = results[i].stress;
    bool passes = true;
    script += fmt::format("$c{} << EOD\n", count);
    for (; i < results.size() && results[i].stress.name == stress.name; ++i) {
      const RobotStressResult& r = results[i];
      passes = passes && r.failure.empty();
      const auto wrong = [&](double right) { return std::max(kLeast_percent, 100 * (1 - right)); };
      script += fmt::format("{:g} {:.6g} {:.6g} {:.6g} {:.6g}\n", r.point.at, wrong(r.median), wrong(r.least),
                            wrong(r.start_median), wrong(r.point.least));
    }
    script += "EOD\n";
    panels += fmt::format(
        "set title {} noenhanced tc rgb '{}'\nset xlabel {} noenhanced\n"
        "plot $c{} using 1:2 with linespoints pt 7 lw 2 lc rgb '#1f5fbf' title 'median', "
        "$c{} using 1:3 with linespoints pt 5 lw 2 lc rgb '#b36b00' title 'worst scan', "
        "$c{} using 1:5 with lines dt 2 lc rgb '#c03030' title 'its limit', "
        "$c{} using 1:4 with linespoints pt 9 lc rgb '#888888' title 'without a stroke'\n",
        gnuplot_quoted(stress.name + (passes ? ": within its limits" : ": NOT WITHIN ITS LIMITS")),
        passes ? "#1a7f37" : "#c03030", gnuplot_quoted(stress.parameter), count, count, count, count);
  }
  script +=
      "set grid lc rgb '#dddddd'\nset key top left font ',9'\nset logscale y\nset yrange [0.008:200]\n"
      "set ylabel 'area labelled wrong, % (0.01: none)'\nset offsets graph 0.05, graph 0.05, 0, 0\n";
  const std::string layout = fmt::format("set multiplot layout 1,{}\n{}unset multiplot\n", count, panels);
  script += fmt::format("set terminal svg size {},420 background rgb 'white'\nset output 'chart.svg'\n",
                        460 * count) +
            layout;
  script += fmt::format("set terminal pngcairo size {},420\nset output 'chart.png'\n", 460 * count) + layout;
  run_gnuplot(script, folder);
}

}  // namespace ohb
