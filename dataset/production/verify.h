// Is a dataset whole and right? Everything that is found goes on a list.
#pragma once

#include <array>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "dataset/model/regions.h"
#include "dataset/production/layout.h"

namespace ohb::production {

struct VerifyJob {
  std::filesystem::path dataset;
  int rerendered = 3;  // sets that are rendered again
  int spp = 32;        // paths of a set that is rendered again, twice
  bool quiet = false;
};

struct VerifyFault {
  std::string where;  // a path below the dataset, or a person's id
  std::string what;
};

struct VerifyReport {
  size_t people = 0, sets = 0, planned_sets = 0, files = 0;
  std::vector<std::string> rerendered;            // "a/view_003.exr"
  std::array<double, kClassCount> class_share{};  // of all covered pixels
  std::vector<VerifyFault> faults;                // sorted by place
  std::vector<std::string> notes;                 // what may be meant so: a class that nobody shows
};

/// Checks of each person: that all planned units are there, made of what the plan says now; sizes and hashes
/// of all their files; files that belong to no unit; render.json against the views. Of each set:
/// sample_faults, and that its header names its person, set and lights. A few sets, drawn by hash, are
/// rendered again (rerender_faults). Throws InputError (not a dataset, a plan that is gone or malformed),
/// TryAgainError (stopped by a signal).
VerifyReport verify_dataset(const VerifyJob& job);

std::string to_text(const VerifyReport& report);
nlohmann::ordered_json to_json(const VerifyReport& report);

}  // namespace ohb::production
