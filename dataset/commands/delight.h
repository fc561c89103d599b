// A scan's texture shows albedo times the light that reached it. Divides by what an even light from all
// around would have left there, where the texture says that it holds such shading.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include <filesystem>
#include <string>
#include <vector>

#include "bake/bake.h"

namespace ohb::commands {

/// What happened to the texels of one class.
struct DelightRegion {
  std::string name;
  uint64_t texels = 0;  // that faces of the class show, in the pictures
  /// How the texture follows the computed irradiance E: the slope of log luminance against log E, over the
  /// positions, both less their mean over the surface around. 1: albedo times E; 0: nothing of it is there.
  double slope = 0;
  bool is_delit = false;
  double mean_irradiance = 1, least_irradiance = 1;  // luminance of E; 1 is open
  double mean_luminance = 0;                         // of the pictures, before and after
  double least_gain = 1, most_gain = 1;              // of a texel's luminance
  double deep_share = 0;  // of its texels: E below kLeastIrradiance, divided by that
};

struct DelightReport {
  std::vector<DelightRegion> regions;    // the classes that occur
  std::vector<std::string> set_folders;  // beside `divisors`
  std::vector<Image> divisors;  // one a set with a picture: what its texels were divided by, 3 channels
};

constexpr float kLeastIrradiance =
    0.15f;                           // deeper, the division says more about the mesh than about the skin
constexpr double kLeastSlope = 0.5;  // below: there is nothing to delight
constexpr int kDelightRays = 256;    // a position

/// Gives the scan's materials new diffuse pictures (half EXR, linear) in `scratch`; `mesh` is the scan's
/// canonical_mesh. Each class keeps its mean colour. Materials with a cut-out keep theirs and cast no shade.
/// Throws as read_image.
DelightReport delight(Scan& scan, const bake::CanonicalMesh& mesh, const std::filesystem::path& scratch);

/// One line for each class that was left alone.
std::vector<std::string> warnings_of(const DelightReport& report);
nlohmann::ordered_json to_json(const DelightReport& report);
std::string to_text(const DelightReport& report);

}  // namespace ohb::commands
