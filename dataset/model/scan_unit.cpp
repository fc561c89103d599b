#include "dataset/model/scan_unit.h"

#include <algorithm>
#include <array>
#include <cstdio>

#include "dataset/model/error.h"
#include "dataset/model/mesh_topology.h"

namespace ohb {
namespace {

constexpr double kShortestHuman_cm = 140, kTallestHuman_cm = 210;
constexpr double kSmallestScan_cm = 15, kLargestScan_cm = 250;  // a bust to a person with raised arms

struct NamedUnit {
  const char* name;
  double cm;
};
constexpr std::array<NamedUnit, 4> kUnits = {{{"mm", 0.1}, {"cm", 1}, {"m", 100}, {"inch", 2.54}}};

std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

const NamedUnit* human_unit(double height) {
  for (const NamedUnit& unit : kUnits)
    if (height * unit.cm >= kShortestHuman_cm && height * unit.cm <= kTallestHuman_cm) return &unit;
  return nullptr;
}

constexpr const char* kAskForUnit = "say which it is with --unit mm, cm, m or inch";

UnitGuess guess_from_height(double height, double wide, double deep) {
  if (const NamedUnit* unit = human_unit(height))
    return {
        unit->cm,
        std::string("a person ") + number_text(height * unit->cm) + " cm high, if the unit is " + unit->name,
        ""};
  const std::string high =
      "the scan is " + number_text(height) + " units high (Y), which fits no standing person";
  if (human_unit(deep) && deep > wide)
    return {std::nullopt, high + ", but it is " + number_text(deep) + " long in Z: it is Z-up or lying",
            "export it with Y up, facing +Z"};
  if (human_unit(wide))
    return {std::nullopt, high + ", but it is " + number_text(wide) + " wide in X: it is X-up or lying",
            "export it with Y up, facing +Z"};
  return {std::nullopt, high + " in mm, cm, m or inch", kAskForUnit};
}

}  // namespace

UnitGuess guess_unit(const Scan& scan) {
  const Bounds bounds = bounds_of_faces(scan);
  const double height = static_cast<double>(bounds.high.y) - bounds.low.y;
  const double wide = static_cast<double>(bounds.high.x) - bounds.low.x;
  const double deep = static_cast<double>(bounds.high.z) - bounds.low.z;
  if (!scan.stated_unit_cm) return guess_from_height(height, wide, deep);
  const double unit_cm = *scan.stated_unit_cm;
  const std::string stated = "the file states " + number_text(unit_cm) + " cm a unit";
  if (height * unit_cm >= kSmallestScan_cm && height * unit_cm <= kLargestScan_cm)
    return {unit_cm, stated, ""};
  return {std::nullopt, stated + ", in which the scan would be " + number_text(height * unit_cm) + " cm high",
          kAskForUnit};
}

double unit_cm_of(const std::string& name) {
  for (const NamedUnit& unit : kUnits)
    if (name == unit.name) return unit.cm;
  throw InputError("--unit", "", "'" + name + "' is no unit", "write mm, cm, m or inch");
}

double resolve_unit_cm(const Scan& scan, const std::optional<std::string>& unit_option) {
  if (unit_option) return unit_cm_of(*unit_option);
  const UnitGuess guess = guess_unit(scan);
  if (!guess.unit_cm) throw InputError(scan.file.string(), "unit", guess.reason, guess.mend);
  return *guess.unit_cm;
}

}  // namespace ohb
