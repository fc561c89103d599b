// Does a picture rendered with baked maps equal one rendered with the scan's own materials? And how large
// must the maps be for that?
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dataset/commands/bake_scan.h"
#include "dataset/model/environment.h"
#include "renderer/validation/statistics.h"

namespace ohb::studies {

/// What must hold where the maps are as large as the pictures.
struct FidelityThresholds {
  double accepted_share = 0.997;  // of the 3 x 3 bins inside the outline
  double ratio = 0.002;           // |baked / source - 1| of the whole picture
  double class_ratio = 0.005;     // of each class: mended seams move dark hair beside skin by 0.3 %
  double least_region_px = 100;   // a class that covers less is shown and not judged
};

struct FidelitySettings {
  std::vector<int> map_sizes_px;  // longer edge of each set's maps; 0: those of its diffuse picture
  int view = 0, view_count = 1;
  int size_px = 256, spp = 32, seeds = 8;
  uint64_t seed = 1;
  FidelityThresholds thresholds;
};

/// Maps of one size. Two kinds of images: those that share their seeds with the source's, so that nearly all
/// noise cancels in the difference, and those with seeds of their own, for the tests.
struct FidelityPoint {
  int map_px = 0;                 // longer edge of the largest set's maps
  bool is_own_size = false;       // each set's maps have its picture's size
  double bake_cpu_s = 0;          // processor seconds of the bake, pictures read included
  double relative_error = 0;      // root mean square of the difference of single pixels, over the mean
  validation::BinTest bins;       // own seeds: inside the outline
  validation::RegionRatio whole;  // own seeds: baked over source
  std::vector<validation::RegionRatio> regions;  // shared seeds: the classes that occur, then "whole image"
  std::vector<std::string> failures;             // what is beyond the thresholds, in words
};

struct BakeFidelity {
  std::string scan, environment;
  bool has_soft_borders = false;  // the regions have weights.exr
  int picture_px = 0;             // longer edge of the largest diffuse picture
  FidelitySettings settings;
  std::vector<FidelityPoint> points;  // from large to small maps
  /// Maps of the pictures' size or larger are within the thresholds.
  bool passes() const;
};

/// Bakes in memory at each size, renders one view with the baked maps and with the scan's own materials, and
/// compares. Throws as bake and source_material_model.
BakeFidelity measure_bake_fidelity(const commands::BakeInputs& inputs, const Environment& environment,
                                   const FidelitySettings& settings);

/// One size against one reference: both models show the same scan. `map_px` and the bake's time stay 0.
FidelityPoint compare_models(const Model& baked, const Model& source, const Environment& environment,
                             const FidelitySettings& settings);

std::string fidelity_text(const BakeFidelity& fidelity);
std::string fidelity_csv(const BakeFidelity& fidelity);
std::string fidelity_json(const BakeFidelity& fidelity);

/// chart.svg and chart.png: error and rejected bins against the maps' size, and error against the bake's
/// time. Throws as run_gnuplot.
void draw_fidelity(const BakeFidelity& fidelity, const std::filesystem::path& folder);

}  // namespace ohb::studies
