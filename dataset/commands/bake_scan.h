// The bake command's work: files in, MODEL folder out.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "bake/bake.h"
#include "dataset/commands/delight.h"

namespace ohb::commands {

struct BakeJob {
  std::filesystem::path scan, regions;
  std::filesystem::path materials;  // empty: assets/materials.xml
  std::string unit;                 // as --unit; empty: guessed
  std::string name;                 // empty: the scan's file name without extension
  int size_px = 0;                  // BakeOptions::size_px
  std::string normals = "auto";     // of the scan's normal maps: opengl, directx, or told from the pictures
  std::filesystem::path source;  // high-resolution mesh of the same subject; empty: the scan's own pictures
  std::string source_unit;       // as --source-unit; empty: as its file states, else the scan's
  std::filesystem::path cage;    // empty: none
  double reach_cm = 0;           // BakeSource::reach_cm
  double max_missed_percent = 100 * bake::kMaxMissedShare,
         max_overlap_percent = 100 * bake::kMaxSourceOverlapShare;
  bool wants_object_normals = false;
  bool keeps_seams = false;  // BakeOptions::mends_seams off
  bool wants_mips = false;
  bool delights = false;         // divides the pictures by the light that is baked into them (delight.h)
  std::filesystem::path output;  // MODEL folder, written whole or not at all
  bool quiet = false;
};

/// A job's files, read.
struct BakeInputs {
  Scan scan, source, cage;  // the last two may be empty
  Regions regions;
  MaterialTable table;
  bake::BakeOptions options;  // points to `source` and `cage`
};

/// Throws InputError: files missing or malformed, regions of another scan, unit not known.
std::unique_ptr<BakeInputs> read_bake_inputs(const BakeJob& job);

/// What bake_scan did. `delight` is empty without BakeJob::delights.
struct BakeScanReport {
  bake::BakeReport bake;
  DelightReport delight;
};
nlohmann::ordered_json to_json(const BakeScanReport& report);
std::string to_text(const BakeScanReport& report);

/// Throws as read_bake_inputs, delight and bake_to_folder; TryAgainError for a full disk.
BakeScanReport bake_scan(const BakeJob& job);

}  // namespace ohb::commands
