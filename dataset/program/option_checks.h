// What the value of an option may be: everything else is refused with the option's name and the range.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>

namespace ohb::program {

/// A number from `low` to `high`, both included. NaN, infinite, empty and what is no number at all is refused
/// (CLI::Range lets NaN through, and words that run over are cut).
CLI::Validator number_within(double low, double high);

/// A whole number from `low` to `high`, both included.
CLI::Validator whole_within(uint64_t low, uint64_t high);

}  // namespace ohb::program
