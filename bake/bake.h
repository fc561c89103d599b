// The six UV maps of a labelled scan, in the scan's own UV layout (same mesh: no rays are needed).
// Later: a high-resolution source baked onto a low mesh, soft class borders.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "bake/bake_report.h"
#include "bake/canonical_mesh.h"
#include "dataset/model/material_table.h"
#include "dataset/model/model.h"
#include "dataset/model/regions.h"
#include "dataset/model/scan.h"

namespace ohb {

constexpr int kMaxMapSize_px = 8192;
constexpr int kSizeWithoutPicture_px = 1024;

/// Which way the green channel of a scan's normal map points: up (OpenGL), down (DirectX: turned over), or
/// not known (read as up, with a warning).
enum class GreenChannel { kUp, kDown, kUnclear };

struct BakeOptions {
  /// Texels along the longer edge of each set's maps (the shorter keeps the picture's shape); 0: as many as
  /// the set's diffuse picture has, kSizeWithoutPicture_px without one, at most kMaxMapSize_px.
  int size_px = 0;
  double unit_cm = 1;               // cm a unit of the scan
  std::string unit_reason;          // for the report
  std::string name;                 // of the model
  bool quiet = true;                // no progress bar
  std::vector<GreenChannel> green;  // of each of the scan's materials; empty: all up
};

/// The material at a point from the share of each class there: the mean of specular, roughness and sss
/// weighted by the shares. The one place where classes become values.
ClassMaterial mix_classes(const MaterialTable& table, const std::array<float, kClassCount>& shares);

/// The maps of one set of the mesh. Throws InputError for a picture that cannot be read.
TextureSet bake_texture_set(const CanonicalMesh& mesh, const Scan& scan, uint16_t set,
                            const MaterialTable& table, const BakeOptions& options, SetReport& report);

/// Bakes a scan into `folder` (give an AtomicFolder's path), one set after the other so that only one set's
/// maps are in memory: about 60 bytes a texel (3.6 GB at 8192 x 8192). Also writes report.json. The bytes do
/// not depend on the number of threads. Throws as canonical_mesh, bake_texture_set and write_model.
BakeReport bake_to_folder(const Scan& scan, const Regions& regions, const MaterialTable& table,
                          const BakeOptions& options, const std::filesystem::path& folder);

/// The same in memory.
Model bake(const Scan& scan, const Regions& regions, const MaterialTable& table, const BakeOptions& options,
           BakeReport* report = nullptr);

}  // namespace ohb
