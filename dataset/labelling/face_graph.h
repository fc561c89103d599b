// The graph that labels spread over: one node a face, one edge where two faces meet on the welded mesh, and
// bridges between components that lie close to each other (hair on a head, a garment on a body).
#pragma once

#include <cstdint>
#include <vector>

#include "dataset/labelling/scan_surface.h"

namespace ohb::labelling {

/// Two faces that meet, or that a bridge joins. Lengths are in cm.
struct FaceEdge {
  uint32_t a, b;      // a < b
  float length_cm;    // of the shared border. Bridge: the area of what it joins over the bridges' reach
  float distance_cm;  // between the faces' centres over the border; at least a hundredth of the length
  float fold;         // sine of half the angle between the normals: > 0 on ridges, < 0 in creases
  bool is_bridge;
};

struct FaceNeighbour {
  uint32_t face, edge;
};

struct FaceGraph {
  std::vector<Vec3f> centre_cm;  // mean of the corners, in the scan's axes
  std::vector<Vec3f> normal;     // unit; (0,0,0) without area
  std::vector<float> area_cm2;
  std::vector<FaceEdge> edges;            // sorted by (a, b), no pair twice
  std::vector<uint32_t> first_neighbour;  // neighbours of face f: [first_neighbour[f], first_neighbour[f+1])
  std::vector<FaceNeighbour> neighbours;
  std::vector<uint32_t> component;  // of the welded mesh, without bridges
  uint32_t component_count = 0;
  uint64_t bridge_count = 0, non_manifold_edges = 0;  // edges of more than two faces

  size_t size() const { return area_cm2.size(); }
};

/// How far apart two components may lie and still be bridged.
constexpr double kBridgeReach_cm = 0.6;

/// Around an edge of more than two faces each is joined with the next in face order, so that no stroke stops
/// there. Every point within reach of another component gives one bridge to that component's nearest face.
FaceGraph face_graph(const ScanSurface& surface);

}  // namespace ohb::labelling
