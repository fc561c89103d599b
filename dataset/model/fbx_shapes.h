// Shape keys of FBX: offsets of a mesh's vertices, each with a weight.
#pragma once

#include <string>
#include <vector>

#include "dataset/model/affine.h"
#include "dataset/model/fbx_scene.h"

namespace ohb {

/// Adds the mesh's shape keys to its positions (of `geometry`, untransformed) at the weights that the file
/// states, as Blender 3.4 shows them: DeformPercent from 0 to 100, times FullWeights. Says in `notes` which
/// are applied and how many rest at 0. Animations of the weights are not read. Throws InputError naming
/// `place` for a vertex that the mesh has not.
void apply_fbx_shapes(const FbxScene& scene, const FbxNode& geometry, const std::string& place,
                      std::vector<Vec3d>& positions, std::vector<std::string>& notes);

}  // namespace ohb
