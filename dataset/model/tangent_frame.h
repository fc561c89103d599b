// MikkTSpace tangents (Mikkelsen 2008), one a triangle corner, as Blender and Cycles compute them.
#pragma once

#include <vector>

#include "dataset/model/model.h"

namespace ohb {

/// The tangent frame of a corner: B = sign x cross(N, T). T is orthogonal to the corner's normal before
/// interpolation; interpolate T and N without normalising them (renderer and bake alike).
struct CornerTangent {
  Vec3f tangent;
  float sign;  // +1 or -1
};

/// 3 x triangles.size() tangents, corner c of triangle t at 3 t + c. `normals` are smooth_normals(model).
/// Corners are welded where position, normal and UV are exactly equal; zero-UV-area triangles take their
/// neighbours' frame; an isolated degenerate one gets T = (1,0,0), sign -1 (as mikktspace.c does).
std::vector<CornerTangent> mikktspace_tangents(const Model& model, const std::vector<Vec3f>& normals);

}  // namespace ohb
