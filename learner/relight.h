// The person of a maps folder in Blender, relit and edited: blender_addon/relight.py without its chatter.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace ohb::learner {

/// What relight.py's arguments of these names mean; texts are passed on as they are.
struct RelightOptions {
  std::filesystem::path maps;         // docs/maps_json.md
  std::filesystem::path output;       // .png or .exr, written whole or not at all
  std::filesystem::path environment;  // latitude-longitude, linear; empty: none
  std::vector<std::string> points;    // "x,y,z,I": cm, and irradiance at 1 m
  std::vector<std::string> edits;     // "CLASS:PRESET" or "CLASS:#rrggbb"
  double rotation_deg = 0;            // of the environment about +Y
  double strength = 1;                // factor on the environment
  double subsurface_scale = 1;        // factor on the subsurface map
  int size_px = 0;                    // width of the picture; 0: that of the maps
  int spp = 64;
  uint64_t seed = 1;  // below 2^31
  std::string background = "transparent";
  std::filesystem::path blender;  // program; empty: `blender` in PATH
  int threads = 0;                // 0: all
};

/// The report of relight.py: output, size_px, seconds {load, render}, blender, principled, warnings (which
/// are also logged). Throws InputError: no Blender, one before 3.4, or what relight.py refuses, in its words;
/// an output that is one of the inputs or belongs to another output.
/// TryAgainError: the disk is full, a signal ended Blender or us, or Blender found no memory. Before what
/// Blender itself fails with, its last lines go to stderr.
nlohmann::json relight(const RelightOptions& options);

}  // namespace ohb::learner
