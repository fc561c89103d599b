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

/// A human is 140 to 210 cm high, which fits one of mm, cm, m and inch at most. A unit that the file states
/// counts if the scan is 15 to 250 cm high in it.
UnitGuess guess_unit(const Scan& scan);

/// cm of "mm", "cm", "m" or "inch". Throws InputError for another word.
double unit_cm_of(const std::string& unit);

/// The unit for everything that follows: the user's word if there is one, else the guess.
/// Throws InputError that asks for --unit (or for a scan with Y up) if neither tells.
double resolve_unit_cm(const Scan& scan, const std::optional<std::string>& unit_option);

}  // namespace ohb
