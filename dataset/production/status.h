// How far a production is, from its markers: nothing is locked, read whole or changed.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "dataset/production/layout.h"

namespace ohb::production {

struct PersonStatus {
  std::string id, split;
  bool is_baked = false;
  size_t sets = 0, set_count = 0;
  bool is_at_work = false;  // a worker of this machine holds the person's lock
  std::string failure;      // why the person was given up; empty: was not
};

struct DatasetStatus {
  std::string plan;
  bool plan_changed = false;  // since the last `produce`
  size_t sets = 0, set_count = 0, done_people = 0;
  /// Of the sets of the last ten minutes of work; none with fewer than two sets.
  std::optional<double> sets_per_hour;
  std::optional<double> hours_left;  // at that rate
  std::optional<double> idle_s;      // since the last set was finished
  std::vector<PersonStatus> people;
};

/// Throws InputError: not a dataset, of a newer version, a plan that is not there any more or is malformed.
DatasetStatus status_of(const Layout& layout);

/// A bar a person, what failed and why, and how long it will take.
std::string to_text(const DatasetStatus& status);
nlohmann::ordered_json to_json(const DatasetStatus& status);

}  // namespace ohb::production
