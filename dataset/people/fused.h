// A person as photogrammetry gives it: one closed surface over skin, hair and clothes, with a picture of its
// own.
#pragma once

#include "dataset/people/scan_bake.h"

namespace ohb::people {

constexpr float kFusedVoxel_cm = 0.6f;

/// Wraps the scan: what cannot be reached from outside through gaps wider than about two voxels is solid; its
/// surface (naive surface nets, Gibson 1998) is drawn back onto the scan. Charts are flat projections;
/// picture and classes come from the nearest point of the scan. Every edge has as many faces on one side as
/// on the other.
ScannedPerson fused(const ScannedPerson& scan, float voxel_cm = kFusedVoxel_cm);

}  // namespace ohb::people
