// What a high-resolution source gives to the maps of a low mesh: one pass over the texels.
#pragma once

#include <memory>
#include <vector>

#include "bake/canonical_mesh.h"
#include "bake/seams.h"
#include "bake/source_rays.h"
#include "dataset/surface/texel_coverage.h"

namespace ohb::bake {

/// What all sets of a bake from a source share.
struct SourceBake {
  std::shared_ptr<const SourceSurface> surface;
  float outward_cm = 0, inward_cm = 0;  // the reach
  std::vector<Vec3f> cage_offset;       // of each position of the low mesh; empty: along its smooth normal
  const MeshFrames* frames = nullptr;   // of the low mesh
  bool wants_object_normals = false;
};

/// The maps of one set that come from the source; texels without a source point hold 0.
struct SourceMaps {
  Image albedo, alpha;             // alpha: empty if the source has none
  Image normal, object_normal;     // object_normal: empty unless wanted
  Image displacement, height;      // cm: z of the source's point; its distance along the low mesh's normal
  std::vector<RayResult> results;  // one a texel
};

/// The coordinates of a direction in the frame that a renderer decodes with, x T + y B + z N, T and N
/// interpolated and not normalised, B = sign x cross(N, T): the exact inverse, then unit length.
/// (0,0,1) where the frame has no volume.
Vec3f to_tangent_space(Vec3f direction, Vec3f tangent, Vec3f normal, float sign);

/// `triangles`: indices into the model's, in the order of `coverage` and `uvs`. Any thread count, same bits.
SourceMaps bake_from_source(const Model& low, const std::vector<uint32_t>& triangles,
                            const std::vector<surface::UvTriangle>& uvs,
                            const surface::TexelCoverage& coverage, const SourceBake& bake);

}  // namespace ohb::bake
