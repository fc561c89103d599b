// Bad unwraps, meshes and sources: named cases with a parameter that goes from harmless to impossible, what a
// lookup on the baked surface then finds, and what is acceptable (assets/stress/bake_catalogue.json).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dataset/studies/hard_cases.h"

namespace ohb::studies {

/// What one value of a case must keep; what is not set is not asked.
struct BakeStressAcceptance {
  double normal_deg = -1;  // angular error that 95 % of the surface stay below, in the model's frame
  double colour = -1;      // the same of the largest channel's error of the linear albedo
  double alpha = -1;       // the same of the cut-out
  double depth_cm = -1;    // the same of the displacement
  double wrong = -1;       // share of the surface whose normal is off by 3 degrees or albedo by 0.05
  std::string refused;     // words of the refusal that must come; empty: none may
  std::string warned;      // words that a warning must hold; empty: not asked
};

using BakeStressPoint = HardPoint<BakeStressAcceptance>;
using BakeStressCase = HardCase<BakeStressPoint>;

/// Throws InputError with the case that is wrong.
std::vector<BakeStressCase> read_bake_stress_catalogue(const std::filesystem::path& file);

struct BakeStressResult {
  BakeStressPoint point;
  std::string refusal;                // of the bake; empty: it was done
  std::vector<std::string> warnings;  // its own
  double normal_deg = 0, colour = 0, alpha = 0, depth_cm = 0, wrong = 0;
  size_t nonfinite = 0;               // texels of all maps
  std::vector<std::string> failures;  // what is not acceptable, with the figures
};

using BakeStressCaseResult = HardCaseResult<BakeStressCase, BakeStressResult>;

/// Bakes every point, or those of the case `only`. `scratch` is a folder for pictures.
std::vector<BakeStressCaseResult> run_bake_stress(const std::vector<BakeStressCase>& catalogue,
                                                  const std::string& only,
                                                  const std::filesystem::path& scratch);

std::string bake_stress_csv(const std::vector<BakeStressCaseResult>& results);
std::string bake_stress_json(const std::vector<BakeStressCaseResult>& results);

/// chart.svg and chart.png: a panel a case. Throws as run_gnuplot.
void draw_bake_stress(const std::vector<BakeStressCaseResult>& results, const std::filesystem::path& folder);

}  // namespace ohb::studies
