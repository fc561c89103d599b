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

StressCase case_of(const json& from) {
  return read_hard_case<StressPoint>(from, acceptance_of, [](const json& object, StressPoint& point) {
    point.cycles = object.value("in_cycles", true);
    point.heavy = object.value("heavy", false);
  });
}

}  // namespace

std::vector<StressCase> read_stress_catalogue(const fs::path& file) {
  return read_json_catalogue<StressCase>(file, "assets/stress/catalogue.json", case_of);
}

}  // namespace ohb::studies
