// Faces that a scan has twice.
#pragma once

#include <vector>

#include "dataset/model/scan.h"

namespace ohb::bake {

/// One a face: whether it is an exact copy of an earlier face of its material, with the same positions in any
/// order and, where the material has a cut-out, the same UVs at them (layers of strands that differ add up).
/// Of opaque copies only one is ever seen. n log n in the corners.
std::vector<bool> repeated_faces(const Scan& scan);

}  // namespace ohb::bake
