// The scenes of the bake's stress catalogue: a flat or curved sheet of 1 m, baked from a waved one whose
// height, normal and colour are known at every point.
#pragma once

#include <filesystem>
#include <string>

#include "bake/bake.h"

namespace ohb::studies {

/// At a point (x, y) of the sheet, in the scan's frame (cm).
struct SheetTruth {
  Vec3f normal, albedo;  // unit; linear
  float z = 0, alpha = 1;
};

struct BakeStressScene {
  Scan low, source;  // the source may be empty
  Regions regions;
  bake::BakeOptions options;  // its source points to `source`
  size_t measured_faces = 0;  // the first faces of `low`: those that are of the sheet
  Vec3f place;                // of the sheet's corner: truth is asked at a point less it
  bool has_alpha = false;
};

/// The wave and its colours: periods of 1 m, 1 cm high.
SheetTruth sheet_truth(float x, float y);

/// Throws InputError, naming all scenes, for a name that is none of them.
void make_bake_stress_scene(const std::string& name, double at, const std::filesystem::path& scratch,
                            BakeStressScene& scene);

}  // namespace ohb::studies
