// The UV maps of a labelled scan, in the scan's own UV layout: from its own pictures (no rays are
// needed), or from a high-resolution source.
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
#include "dataset/surface/picture.h"

namespace ohb::bake {

constexpr int kMaxMapSize_px = 8192;
constexpr int kSizeWithoutPicture_px = 1024;

/// A high-resolution source in the frame of the scan: its position in cm = source position x unit_cm + the
/// shift of the low mesh.
struct BakeSource {
  const Scan* scan = nullptr;
  std::string sha256;  // of its file, for the report
  double unit_cm = 1;
  std::vector<surface::GreenChannel> green;  // of each of its materials; empty: all up
  /// How far from the low mesh it may lie, either way; 0: kReachShare of the low mesh's diagonal.
  double reach_cm = 0;
  /// The low mesh with its points moved outwards: how far and in which direction each ray looks outwards.
  const Scan* cage = nullptr;
  bool wants_object_normals = false;  // writes normal_object.exr too
  double max_missed_share = kMaxMissedShare, max_overlap_share = kMaxSourceOverlapShare;
};

struct BakeOptions {
  /// Texels along the longer edge of each set's maps (the shorter keeps the picture's shape); 0: as many as
  /// the set's diffuse picture has (without one the source's largest, without that kSizeWithoutPicture_px),
  /// at most kMaxMapSize_px.
  int size_px = 0;
  double unit_cm = 1;                        // cm a unit of the scan, for its canonical_mesh
  std::string unit_reason;                   // for the report
  std::string name;                          // of the model
  bool quiet = true;                         // no progress bar
  std::vector<surface::GreenChannel> green;  // of each of the scan's materials; empty: all up
  bool mends_seams = true;                   // makes the two sides of each seam agree
  bool wants_mips = false;  // writes each map with its mip levels, whose seams are mended too
  /// weights.exr (the shares of the classes) of REGIONS, one for each of the scan's materials; where there is
  /// none, borders are hard.
  std::vector<std::filesystem::path> class_weights;
  BakeSource source;  // its scan is null: the scan's own pictures
};

/// The material at a point from the share of each class there: the mean of each
/// value weighted by the shares. The one place where classes become values.
ClassMaterial mix_classes(const MaterialTable& table, const std::array<float, kClassCount>& shares);

/// Bakes a scan, of which `mesh` is the canonical_mesh, into `folder` (give an AtomicFolder's path), one map
/// after the other so that few are in memory at once. Also writes report.json. The bytes do not depend on the
/// number of threads. Throws as SetBake and write_model_mesh, and where the source is not of the subject.
BakeReport bake_to_folder(const Scan& scan, CanonicalMesh mesh, const MaterialTable& table,
                          const BakeOptions& options, const std::filesystem::path& folder);

/// The same in memory, of the mesh that it makes itself. Throws as canonical_mesh, too.
Model bake_model(const Scan& scan, const Regions& regions, const MaterialTable& table,
                 const BakeOptions& options, BakeReport* report = nullptr);

}  // namespace ohb::bake
