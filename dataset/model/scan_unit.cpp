#include "dataset/model/scan_unit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <tuple>

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
constexpr std::array<NamedUnit, 5> kUnits = {
    {{"mm", 0.1}, {"cm", 1}, {"m", 100}, {"inch", 2.54}, {"foot", 30.48}}};

/// Extents along X, Y and Z.
struct Size {
  double wide, high, deep;
};
Size size_of(const Scan& scan) {
  const Bounds bounds = bounds_of_faces(scan);
  return {static_cast<double>(bounds.high.x) - bounds.low.x,
          static_cast<double>(bounds.high.y) - bounds.low.y,
          static_cast<double>(bounds.high.z) - bounds.low.z};
}

/// A standing person: highest in Y (in width only spread arms are as much), and not deep.
bool stands(const Size& size) {
  return size.wide < 1.15 * size.high && size.deep < 0.6 * size.high;
}

/// A person along `length`: much less high, yet no drawing on a plane, and not wider than spread arms are.
bool lies(double length, double high, double third) {
  return high > 0 && high < 0.6 * length && third < 1.15 * length;
}

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

constexpr const char* kAskForUnit = "say which it is with --unit mm, cm, m, inch or foot";
constexpr const char* kLyingMend = "turn it with --up z (or -z, x, -x); --up y if it is meant to lie";
constexpr const char* kPart = "a part of a person, or an object";

/// "30 cm high (Y) and 170 cm long in Z"; `letter`: the long axis.
std::string lying_text(double high, double length, char letter, const std::string& unit) {
  return number_text(high) + unit + " high (Y) and " + number_text(length) + unit + " long in " + letter +
         ": it lies, or it is " + letter + "-up";
}

UnitGuess guess_from_height(const Size& size) {
  const NamedUnit* unit = human_unit(size.high);
  const bool is_foot = unit && unit->cm == 30.48;
  if (unit && (!is_foot || stands(size)))
    return {unit->cm,
            std::string("a person ") + number_text(size.high * unit->cm) + " cm high, if the unit is " +
                unit->name,
            ""};
  const std::string mend = "turn it with --up z (or -z, x, -x), or export it with Y up, facing +Z";
  if (human_unit(size.deep) && lies(size.deep, size.high, size.wide))
    return {std::nullopt, "the scan is " + lying_text(size.high, size.deep, 'Z', " units"), mend};
  if (human_unit(size.wide) && lies(size.wide, size.high, size.deep))
    return {std::nullopt, "the scan is " + lying_text(size.high, size.wide, 'X', " units"), mend};
  return {std::nullopt,
          "the scan is " + number_text(size.high) +
              " units high (Y), which fits no standing person in mm, cm, m, inch or foot: " + kPart +
              ", or another unit",
          kAskForUnit};
}

}  // namespace

UnitGuess guess_unit(const Scan& scan) {
  const Size size = size_of(scan);
  if (!scan.stated_unit_cm) return guess_from_height(size);
  const double unit_cm = *scan.stated_unit_cm;
  const std::string stated = "the file states " + number_text(unit_cm) + " cm a unit";
  if (size.high * unit_cm >= kSmallestScan_cm && size.high * unit_cm <= kLargestScan_cm)
    return {unit_cm, stated, ""};
  const std::string high = ", in which the scan would be " + number_text(size.high * unit_cm) + " cm high";
  const bool is_part = size.high * unit_cm < kSmallestScan_cm && size.high * unit_cm > 0.5;
  return {std::nullopt, stated + high + (is_part ? std::string(": ") + kPart + ", or another unit" : ""),
          kAskForUnit};
}

double unit_cm_of(const std::string& name) {
  for (const NamedUnit& unit : kUnits)
    if (name == unit.name) return unit.cm;
  throw InputError("--unit", "", "'" + name + "' is no unit", "write mm, cm, m, inch or foot");
}

double resolve_unit_cm(const Scan& scan, const std::optional<std::string>& unit_option) {
  if (unit_option) return unit_cm_of(*unit_option);
  const UnitGuess guess = guess_unit(scan);
  if (!guess.unit_cm) throw InputError(scan.file.string(), "unit", guess.reason, guess.mend);
  return *guess.unit_cm;
}

void turn_up(Scan& scan, const std::string& up) {
  if (up.empty() || up == "y") return;
  // Proper turns: faces keep their outside. Signs and exchanges only, so that numbers stay exact.
  const auto turn = [&](auto turned) {
    for (Vec3f& p : scan.positions) p = turned(p);
  };
  if (up == "z")
    turn([](Vec3f p) { return Vec3f{p.x, p.z, -p.y}; });
  else if (up == "-z")
    turn([](Vec3f p) { return Vec3f{p.x, -p.z, p.y}; });
  else if (up == "x")
    turn([](Vec3f p) { return Vec3f{-p.y, p.x, p.z}; });
  else if (up == "-x")
    turn([](Vec3f p) { return Vec3f{p.y, -p.x, p.z}; });
  else if (up == "-y")
    turn([](Vec3f p) { return Vec3f{-p.x, -p.y, p.z}; });
  else
    throw InputError("--up", "", "'" + up + "' is no axis", "write x, y, z, -x, -y or -z");
}

std::string lying_reason(const Scan& scan, double unit_cm) {
  const Size size = size_of(scan);
  for (const auto& [letter, length, third] :
       {std::tuple('Z', size.deep, size.wide), {'X', size.wide, size.deep}})
    if (length * unit_cm >= kShortestHuman_cm && length * unit_cm <= kTallestHuman_cm &&
        lies(length, size.high, third))
      return "the scan is " + lying_text(size.high * unit_cm, length * unit_cm, letter, " cm");
  return "";
}

void expect_upright(const Scan& scan, double unit_cm, const std::string& up) {
  const std::string reason = up.empty() ? lying_reason(scan, unit_cm) : "";
  if (!reason.empty()) throw InputError(scan.file.string(), "", reason, kLyingMend);
}

std::string facing_elsewhere(const Scan& scan) {
  const Size size = size_of(scan);
  if (!stands(size)) return "";
  const double low = bounds_of_faces(scan).low.y;
  struct Slice {
    double x = 0, z = 0, area = 0;
  } feet, ankles;
  for (const ScanTriangle& triangle : triangulate(scan)) {
    Vec3f p[3];
    for (int i = 0; i < 3; ++i) p[i] = scan.positions[scan.corners[triangle.corner[i]].position];
    const double area = 0.5 * length(cross(p[1] - p[0], p[2] - p[0]));
    const double height = ((static_cast<double>(p[0].y) + p[1].y + p[2].y) / 3 - low) / size.high;
    if (height > 0.12 || (height > 0.04 && height < 0.07)) continue;
    Slice& slice = height <= 0.04 ? feet : ankles;
    slice.x += area * (static_cast<double>(p[0].x) + p[1].x + p[2].x) / 3;
    slice.z += area * (static_cast<double>(p[0].z) + p[1].z + p[2].z) / 3;
    slice.area += area;
  }
  if (!(feet.area > 0) || !(ankles.area > 0)) return "";
  const double x = feet.x / feet.area - ankles.x / ankles.area,
               z = feet.z / feet.area - ankles.z / ankles.area;
  constexpr double kClear = 0.015;  // of the height: toes reach 10 cm beyond the shin
  if (std::max(std::abs(x), std::abs(z)) < kClear * size.high) return "";
  if (std::abs(x) > 1.5 * std::abs(z)) return x > 0 ? "+X" : "-X";
  return z < 0 && std::abs(z) > 1.5 * std::abs(x) ? "-Z" : "";
}

}  // namespace ohb
