// A labelled scan as a model's mesh: triangles, centimetres, soles at y = 0, centred.
#pragma once

#include <cstdint>
#include <vector>

#include "dataset/model/model.h"
#include "dataset/model/regions.h"
#include "dataset/model/scan.h"

namespace ohb::bake {

struct CanonicalMesh {
  Model model;                            // sets have their names and no maps yet
  std::vector<uint16_t> material_of_set;  // index into Scan::materials; materials without faces have no set
  std::vector<ScanTriangle> triangles;    // the scan's, of the model's triangles
  size_t repeated_faces = 0;              // of the scan, left out
};

/// Position in cm = source position x unit_cm + shift, the shift such that the lowest used point is at y = 0
/// and the bounding box is centred at x = z = 0; it is recorded in the model. Axes are kept. Positions and
/// UVs that no face uses are left out, and so are repeated_faces(). One texture set a material, in the order
/// of the materials. Throws InputError (naming the scan's file and face) for a face without UVs, with a UV
/// beyond kMaxUv or spanning more than kMaxUvSpan, a face without a class, regions of another number of
/// faces, or where nothing has an area.
CanonicalMesh canonical_mesh(const Scan& scan, const Regions& regions, double unit_cm);

/// Area of triangle t in square centimetres.
double area_cm2(const Model& model, const ModelTriangle& triangle);

}  // namespace ohb::bake
