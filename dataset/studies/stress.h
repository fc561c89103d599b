// The stress catalogue: named cases with a parameter that goes from harmless to impossible, what is measured,
// and what is acceptable.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dataset/model/blender.h"
#include "dataset/studies/hard_cases.h"

namespace ohb::studies {

/// What one value of a case must keep; what is not set is not asked.
struct StressAcceptance {
  double cycles = -1;      // |mean radiance / Cycles' - 1| at most, beyond three standard errors of it
  double first = -1;       // the same against our own image at the case's first value
  double slowdown = -1;    // processor time a path, over that at the first value
  double leaks = -1;       // share of walks that end outside the model
  bool nonfinite = false;  // contributions that are not finite may be counted; NaN pixels never
};

struct StressPoint : HardPoint<StressAcceptance> {
  bool cycles = true;  // is rendered in Cycles too
  bool heavy = false;  // gigabytes or minutes: not in the short test
};
using StressCase = HardCase<StressPoint>;

/// assets/stress/catalogue.json. Throws InputError with the case that is wrong.
std::vector<StressCase> read_stress_catalogue(const std::filesystem::path& file);

struct StressSettings {
  int size_px = 32, spp = 256, seeds = 4;
  int threads = 0;
  uint64_t seed = 1;
  std::filesystem::path blender;
  bool with_cycles = true, with_heavy = true;
  std::string only;  // one case; empty: all
};

/// One side's images of a point.
struct StressSide {
  bool is_there = false;
  double mean = 0, standard_error = 0;  // of the mean radiance over the picture and the three channels
  double load_s = 0, cpu_us_a_path = 0;
};

struct StressResult {
  StressPoint point;
  StressSide ours, cycles;
  double leaks = 0, nonfinite_share = 0;  // of walks; of paths
  size_t nan_pixels = 0;
  std::vector<std::string> failures;  // what is not acceptable, with the figures
};

using StressCaseResult = HardCaseResult<StressCase, StressResult>;

/// Renders every point here and, if asked, in Cycles 3.4. Throws InputError if Blender is missing.
std::vector<StressCaseResult> run_stress(const std::vector<StressCase>& catalogue,
                                         const StressSettings& settings,
                                         const std::filesystem::path& scratch);

std::string stress_csv(const std::vector<StressCaseResult>& results);
std::string stress_json(const std::vector<StressCaseResult>& results);

/// chart.svg and chart.png: a row a case, brightness on the left, time a path on the right. Throws as
/// draw_speed_accuracy.
void draw_stress(const std::vector<StressCaseResult>& results, const std::filesystem::path& folder);

}  // namespace ohb::studies
