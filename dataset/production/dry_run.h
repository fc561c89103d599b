// What a plan will take, from one set of each split measured now.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "dataset/production/plan.h"

namespace ohb::production {

struct SplitForecast {
  std::string split;
  size_t people = 0, sets = 0, lit_images = 0;
  int size_px = 0;
  double set_s = 0;  // maps, lights and file of one, without loading environments
  uint64_t set_bytes = 0;
};

struct MachinesForecast {
  int machines = 1;
  double hours = 0;  // until the last one is done; a person is not shared between machines
};

struct Forecast {
  std::string plan, pilot;  // pilot: id of the person who was measured
  int threads = 0;
  std::vector<SplitForecast> splits;
  size_t people = 0, sets = 0, environments = 0;
  double person_s = 0;       // label, bake, and loading the model
  double environment_s = 0;  // loading one
  uint64_t person_bytes = 0, bytes = 0;
  std::vector<MachinesForecast> machines;  // 1, 16, 147
};

/// Labels and bakes the plan's first person and renders one set for each split, in a folder for temporary
/// files that is removed again. Throws as bake_person and PersonRenderer.
Forecast forecast(const Plan& plan, int threads);

std::string to_text(const Forecast& forecast);
nlohmann::ordered_json to_json(const Forecast& forecast);

}  // namespace ohb::production
