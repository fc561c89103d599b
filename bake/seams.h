// Where a texture set's charts meet: the edges that have two places in UV, and how far the maps differ there.
#pragma once

#include <cstdint>
#include <vector>

#include "dataset/model/image.h"
#include "dataset/model/model.h"
#include "dataset/model/tangent_frame.h"
#include "dataset/surface/texel_coverage.h"

namespace ohb::bake {

/// Smooth normals and MikkTSpace tangents of the mesh that is baked onto.
struct MeshFrames {
  std::vector<Vec3f> normals;           // one a position
  std::vector<CornerTangent> tangents;  // 3 a triangle
};
MeshFrames frames_of(const Model& model);

/// One of an edge's two places. Index 0 and 1 are the same two points on both sides.
struct SeamSide {
  Vec2f uv[2], apex;  // apex: the triangle's third corner
  Vec3f tangent[2], normal[2];
  float sign = 1;
};
struct Seam {
  SeamSide side[2];
};

/// The edges of one set at which two of its triangles meet with different UVs. `triangles`: indices into the
/// model's. An edge of more than two triangles pairs the first with each of the others. Without frames the
/// sides have none.
std::vector<Seam> find_seams(const Model& model, const std::vector<uint32_t>& triangles,
                             const MeshFrames* frames);

constexpr int kSeamLevels = 5;   // mip levels 0 to 4
constexpr int kSeamPoints = 16;  // of each edge

/// What a map's values are, which says how a difference is measured: stored values, linear colours (by their
/// sRGB encoding, as it is seen), tangent-space normals (by the angle in the model's frame, degrees), or
/// lengths in cm.
enum class MapValues { kPlain, kLinearColour, kNormals, kLength };

/// Differences between the two sides at kSeamPoints of every edge, at one mip level.
struct SeamError {
  double mean = 0, percentile_99 = 0, max = 0;
  double share_above = 0;  // above 1/255, or 1 degree for normals
};

/// One a level, of the first `levels`. The levels are means over blocks of 2^level texels, lookups bilinear:
/// what a renderer does.
std::vector<SeamError> seam_errors(const Image& map, const std::vector<Seam>& seams, MapValues values,
                                   int levels = kSeamLevels);

/// A place on one side, between its two points, as a bilinear lookup at one mip level: blocks of texels and
/// their weights.
struct SeamLookup {
  int column[2], row[2];  // of the level's blocks, wrapped
  float weight[2][2];     // [row][column]
};
SeamLookup lookup_at(const SeamSide& side, float along, int level, int width_px, int height_px);

/// The weights of a direction's coordinates x, y, z in a side's frame between its two points (T, B and N, not
/// normalised).
struct SeamFrame {
  Vec3f tangent, bitangent, normal;
};
SeamFrame frame_at(const SeamSide& side, float along);
inline Vec3f to_model(const SeamFrame& frame, Vec3f v) {
  return v.x * frame.tangent + v.y * frame.bitangent + v.z * frame.normal;
}

}  // namespace ohb::bake
