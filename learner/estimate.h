// From a photograph to a folder of maps (docs/maps_json.md).
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "learner/estimator.h"
#include "learner/matting.h"
#include "learner/photo.h"

namespace ohb::learner {

struct EstimateOptions {
  std::filesystem::path photo;
  std::optional<std::filesystem::path> mask;
  MattingOptions matting;                      // where there is neither a mask nor an alpha
  std::vector<std::filesystem::path> weights;  // files or runs: as Estimator takes them
  std::filesystem::path output;                // folder, written whole or not at all
  int size_px = 0;                             // of the maps; 0: the photo's own, see natural_size
  double person_height_cm = 170;  // of what the mask covers from top to bottom: nothing else gives the scale
};

/// Sides of maps that keep what a photo shows of the person: the crop's pixels, to a multiple of 16, at least
/// as many as the networks see and at most 1024.
int natural_size(const Crop& crop, int network_px);

struct EstimateReport {
  Crop crop;
  int size_px = 0;
  bool finetuned = false;
  int people = 0;      // found by matting; 0: the mask was given
  double seconds = 0;  // of the networks
};

/// Writes the mask and each map as 16-bit PNG, the same maps in float as maps.exr (parts named as in a
/// sample, displacement in cm, normals signed, albedo linear), input.png as the networks saw it, and
/// maps.json. Where the mask is 0 all maps are 0, normals (0, 0, 1). Throws InputError: photo, mask or
/// weights as their readers say; an output that this program did not write.
EstimateReport estimate(const EstimateOptions& options);

}  // namespace ohb::learner
