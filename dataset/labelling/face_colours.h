// The diffuse colour of faces, from their texels.
#pragma once

#include <array>
#include <vector>

#include "dataset/model/scan.h"
#include "dataset/model/vec.h"
#include "dataset/surface/texel_coverage.h"

namespace ohb::labelling {

/// The triangles of one material that have usable UVs, with their faces.
struct MaterialTriangles {
  std::vector<uint32_t> face;
  std::vector<std::array<uint32_t, 3>> corners;  // into Scan::corners
  std::vector<surface::UvTriangle> uvs;
  size_t unusable = 0;  // missing or out of range
};
MaterialTriangles material_triangles(const Scan& scan, const std::vector<ScanTriangle>& triangles,
                                     size_t material);

/// Mean diffuse colour of each face, linear Rec. 709: the average of the texels of its picture whose centre
/// it holds (the one at its middle if it holds none), times the diffuse factor and the colours at its
/// vertices; those alone without a picture or without UVs. Throws InputError for a picture that cannot be
/// read.
std::vector<Vec3f> mean_face_colours(const Scan& scan);

/// Mean and standard deviation of the same texels in CIE L*a*b* (without the factor, unless it is all there
/// is: then the deviation is 0).
struct FaceColour {
  Vec3f lab, spread;
};
std::vector<FaceColour> lab_face_colours(const Scan& scan);

}  // namespace ohb::labelling
