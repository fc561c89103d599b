// Turns an InspectReport's measures into warnings; inspect.cpp is the only user.
#pragma once

#include "dataset/commands/inspect.h"

namespace ohb::commands {

/// The warnings that the measures call for, most serious first.
std::vector<Warning> inspect_warnings(const InspectReport& report, bool unit_given);

}  // namespace ohb::commands
