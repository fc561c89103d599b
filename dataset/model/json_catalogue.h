// Data files that hold a list of cases: {"cases": [...]}.
#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

#include "dataset/model/error.h"
#include "dataset/model/json_text.h"

namespace ohb {

/// Each of the file's cases by case_of(json). `example` names a file that is written as it should be. Throws
/// InputError, naming file and case, for what is missing, of the wrong type, or refused by case_of.
template <class Case>
std::vector<Case> read_json_catalogue(const std::filesystem::path& file, const std::string& example,
                                      Case (*case_of)(const nlohmann::json&)) {
  std::vector<Case> catalogue;
  std::string place = "the file";
  const nlohmann::json whole = read_json(file);
  try {
    for (const nlohmann::json& each : whole.at("cases")) {
      place = fmt::format("case {}", catalogue.size() + 1);
      if (each.contains("name")) place += fmt::format(" ({})", each.at("name").get<std::string>());
      catalogue.push_back(case_of(each));
    }
  } catch (const nlohmann::json::exception& error) {
    throw InputError(file.string(), place, error.what(), fmt::format("write it as {} is written", example));
  } catch (const InputError& error) {
    throw InputError(file.string(), place, error.what(), "");
  }
  return catalogue;
}

}  // namespace ohb
