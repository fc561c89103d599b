// The people command: a folder of scans from a folder of assets.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "dataset/people/recipe.h"
#include "dataset/people/scan_bake.h"

namespace ohb::people {

struct PeopleJob {
  std::filesystem::path assets, output;
  int count = 1;
  DrawOptions draw;
  ScanOptions scan;
  bool fused = false;  // one closed surface, as photogrammetry gives
  int preview_px = 384;
  bool quiet = false;
};

struct MadePerson {
  std::string name;
  Recipe recipe;
  bool was_there = false;
  double seconds = 0;
};

struct PeopleReport {
  std::vector<MadePerson> people;
  double seconds = 0;
};

constexpr int kMaxPeople = 9999;

/// Writes job.output/<name>/<name>_scan.* for each person, people.json and contact_sheet.png. A person that
/// is there as asked for is left as it is; one that an earlier run was stopped at is made anew. Throws
/// InputError (assets, output), TryAgainError (disk full; SIGINT or SIGTERM: finished people are kept).
PeopleReport make_people(const PeopleJob& job);

nlohmann::json to_json(const PeopleReport& report);

}  // namespace ohb::people
