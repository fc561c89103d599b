// The one place that decides how long a scan's unit is. Nothing rescales without it.
#pragma once

#include <optional>
#include <string>

#include "dataset/model/scan.h"

namespace ohb {

/// What the file and the height along Y say about the unit.
struct UnitGuess {
  std::optional<double> unit_cm;  // cm a unit; none: it cannot be told
  std::string reason;             // why, in words
  std::string mend;               // what the user can do; empty if unit_cm is certain
};

/// A human is 140 to 210 cm high, which fits one of mm, cm, m and inch at most; feet are taken only where the
/// scan has a standing person's proportions too. A unit that the file states counts if the scan is 15 to 250
/// cm high in it.
UnitGuess guess_unit(const Scan& scan);

/// cm of "mm", "cm", "m", "inch" or "foot". Throws InputError for another word.
double unit_cm_of(const std::string& unit);

/// Turns a scan so that the axis that points up becomes +Y: "x", "y", "z", "-x", "-y" or "-z" as --up says;
/// "" and "y" change nothing. "z" makes -Y the front, as Blender has it; the others keep Z. Every command
/// that reads a scan calls it right after: what follows (strokes, labels, maps) is in the turned axes, and
/// Regions::up tells bake. Throws InputError for another word.
void turn_up(Scan& scan, const std::string& up);

/// Why the scan seems to lie: as long as a person along X or Z, and flat in Y. Empty if it does not.
/// The mend is --up.
std::string lying_reason(const Scan& scan, double unit_cm);
/// Throws InputError with lying_reason where `up` is empty: the user did not say that it is meant.
void expect_upright(const Scan& scan, double unit_cm, const std::string& up);

/// Where a standing person's feet point, if that is not +Z: "-Z", "+X" or "-X"; "" if they point to +Z or
/// nothing can be told. Compares the lowest 4 % of the height with what is above.
std::string facing_elsewhere(const Scan& scan);

/// The unit for everything that follows: the user's word if there is one, else the guess.
/// Throws InputError that asks for --unit (or for a scan with Y up) if neither tells.
double resolve_unit_cm(const Scan& scan, const std::optional<std::string>& unit_option);

constexpr const char* kUpHelp = "the axis of the file that points up: y, z, x, -y, -z or -x (default: y)";
constexpr const char* kUnitHelp = "unit of the scan: mm, cm, m, inch or foot (default: guessed)";

}  // namespace ohb
