// What the report says of one texture set's geometry, and the limits that a bake from a source must keep.
#pragma once

#include "bake/bake.h"
#include "dataset/model/model.h"
#include "dataset/surface/texel_coverage.h"

namespace ohb::bake {

struct SetTriangles;
struct SourceBake;

void report_geometry(const Model& model, const SetTriangles& triangles,
                     const surface::TexelCoverage& coverage, SetReport& report);

/// Throws if more of the set's texels show two faces than `limits` allow: each would need its own texels.
void check_overlaps(const SetReport& report, const BakeSource& limits);

/// Throws if more of the set's texels miss the source than `limits` allow.
void check_misses(const SetReport& report, const SourceBake& source, const BakeSource& limits);

}  // namespace ohb::bake
