#include "dataset/model/json_catalogue.h"
#include "dataset/studies/stress.h"

namespace ohb::studies {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

StressAcceptance acceptance_of(const json& from, StressAcceptance base) {
  for (const auto& [key, value] : from.items()) {
    if (key == "cycles")
      base.cycles = value.is_null() ? -1 : value.get<double>();
    else if (key == "first")
      base.first = value.is_null() ? -1 : value.get<double>();
    else if (key == "slowdown")
      base.slowdown = value.get<double>();
    else if (key == "leaks")
      base.leaks = value.is_null() ? -1 : value.get<double>();
    else if (key == "nonfinite")
      base.nonfinite = value.get<bool>();
    else
      throw InputError("", "accept", "'" + key + "' is no measure", "see dataset/studies/stress.h");
  }
  return base;
}

StressPoint point_of(const json& from, const StressAcceptance& base) {
  StressPoint point;
  point.accept = base;
  if (from.is_number()) {
    point.at = from;
    return point;
  }
  point.at = from.at("at");
  point.cycles = from.value("in_cycles", true);
  point.heavy = from.value("heavy", false);
  if (!from.contains("accept")) return point;
  point.accept = acceptance_of(from.at("accept"), base);
  point.why = from.at("why");
  return point;
}

StressCase case_of(const json& from) {
  StressCase stress;
  stress.name = from.at("name");
  stress.scene = from.at("scene");
  stress.what = from.at("what");
  stress.parameter = from.at("parameter");
  stress.acceptable = from.at("acceptable");
  stress.log_scale = from.value("log", false);
  const StressAcceptance base = acceptance_of(from.at("accept"), {});
  for (const json& point : from.at("points")) stress.points.push_back(point_of(point, base));
  if (stress.points.empty()) throw InputError("", "points", "there are none", "give one at least");
  return stress;
}

}  // namespace

std::vector<StressCase> read_stress_catalogue(const fs::path& file) {
  return read_json_catalogue<StressCase>(file, "assets/stress/catalogue.json", case_of);
}

}  // namespace ohb::studies
