#include "dataset/program/option_checks.h"

#include <fmt/format.h>

#include <charconv>

namespace ohb::program {
namespace {

template <typename Number>
CLI::Validator within(Number low, Number high, const char* kind) {
  const std::string type = fmt::format("{}..{}", low, high);
  return CLI::Validator(
      [=](const std::string& text) {
        Number value{};
        const char* end = text.data() + text.size();
        const auto [at, error] = std::from_chars(text.data(), end, value);
        if (error == std::errc() && at == end && value >= low && value <= high) return std::string();
        return fmt::format("'{}' is not a {} from {} to {}", text, kind, low, high);
      },
      type);
}

}  // namespace

CLI::Validator number_within(double low, double high) {
  return within<double>(low, high, "number");
}

CLI::Validator whole_within(uint64_t low, uint64_t high) {
  return within<uint64_t>(low, high, "whole number");
}

}  // namespace ohb::program
