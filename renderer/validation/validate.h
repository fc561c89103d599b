// One view of one model in Cycles and here, from K seeds a side, and what the comparison says.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "renderer/validation/focus.h"
#include "renderer/validation/sides.h"

namespace ohb::validation {

/// What must hold for a pass.
struct ValidationThresholds {
  double ratio = 0.003;           // |ours / Cycles - 1| of every region, 95 % interval included
  double accepted_share = 0.995;  // of the 3 x 3 bins, silhouette band apart
  int seeds = 8;                  // at least so many a side
  double least_region_px = 25;    // a class that covers less is shown and not judged
};

struct ValidationSettings {
  int view = 0, view_count = 1;
  int size_px = 256, spp = 128, seeds = 8, max_bounces = 32;
  renderer::ShadingModel shading = renderer::ShadingModel::kV1;
  bool subsurface = true;  // false: diffuse reflection instead, on both sides
  /// Regions whose interval is too wide are rendered again, alone, with up to so many times the work.
  double focus = 100;  // 1: never
  int threads = 0;     // 0: all
  uint64_t seed = 1;
  std::filesystem::path blender;  // empty: from PATH
  std::filesystem::path bpy;      // a virtual environment with Blender as a module, instead of a program
  std::filesystem::path kept;     // where the scene is written as a .blend; empty: nowhere
  ValidationThresholds thresholds;
};

/// A region and the work behind it: the first pass's, or that of its own pass.
struct RegionResult {
  RegionRatio ratio;
  SidesWork work;
};

enum class Outcome { kPass, kUndecided, kDifference };

struct Verdict {
  Outcome outcome = Outcome::kPass;
  /// For people: "looks the same; too noisy to be sure of skin within 0.3 %: `--spp 256`, about 4 minutes".
  std::string sentence;
  std::vector<std::string> reasons;  // sentences with the figures; for a pass what was shown
};

struct Validation {
  std::string model_name, environment_name, blender_version;
  ValidationSettings settings;
  bool has_subsurface = false;  // the model has some
  uint64_t nonfinite = 0;       // contributions of ours that were left out
  std::vector<CyclesSetting> blender_settings;
  PixelSets pixels;
  Image coverage;                     // ours, 1 channel
  Moments ours, cycles;               // of the first pass
  std::vector<RegionResult> regions;  // classes that occur, then "whole image"; outline included
  RegionResult band;                  // the outline alone
  BinTest inside_bins, band_bins;
  double coverage_ours = 0, coverage_cycles = 0;  // mean over the image
  SideCost our_cost, cycles_cost;
  double seconds = 0;  // that all of it took
  Verdict verdict;
};

/// How many times sooner our renderer reaches Cycles' error: (time x squared error) of Cycles / ours.
struct SpeedRatio {
  double wall = 0, cpu = 0;
};
SpeedRatio speed_at_equal_error(const Validation& validation);

/// Whether the region has enough pixels to be judged.
bool is_judged(const RegionRatio& region, const ValidationThresholds& thresholds);

/// The verdict of a validation whose other members are filled in.
Verdict judge(const Validation& validation);

/// Renders both sides and compares; then once more, with new seeds, the regions whose interval is wider than
/// 0.8 of the threshold (its half 0.4), with the work that the first pass's spread foretells for each side:
/// those results replace the first. `scratch` is an existing folder for the scene and Cycles' images. Throws
/// InputError if Blender is missing, wrong, or fails.
Validation validate(const Model& model, const Environment& environment, const ValidationSettings& settings,
                    const std::filesystem::path& scratch);

}  // namespace ohb::validation
