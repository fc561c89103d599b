// Which faces meet at which edges, on positions welded across UV seams.
#pragma once

#include <cstdint>
#include <vector>

#include "dataset/model/model.h"
#include "dataset/model/scan.h"

namespace ohb {

/// An edge of the welded mesh and the faces around it (in face order, repeated if a face uses it twice).
struct MeshEdge {
  uint32_t point[2];   // point[0] < point[1]
  uint32_t first_use;  // MeshTopology::uses[first_use, first_use + use_count)
  uint32_t use_count;
};

struct EdgeUse {
  uint32_t face;
  bool forward;  // the face goes from point[0] to point[1]
};

struct MeshTopology {
  static constexpr uint32_t kNoPoint = 0xffffffffu;
  std::vector<uint32_t> point_of_position;  // welded point of each position; kNoPoint where no face uses it
  uint32_t point_count = 0;
  std::vector<MeshEdge> edges;  // sorted by their points; edges of one point (degenerate faces) are left out
  std::vector<EdgeUse> uses;
  std::vector<uint32_t> component_of_face;  // faces that meet at edges; numbered by their first face
  uint32_t component_count = 0;
};

/// Positions closer than `weld_share` (> 0) of the diagonal of the faces' bounding box become one point; a
/// chain of close positions does not weld further than that from its first one. Linear time.
MeshTopology mesh_topology(const Scan& scan, double weld_share = 1e-5);

/// The bounding box of the positions that faces use, in the scan's unit.
Bounds bounds_of_faces(const Scan& scan);

/// Disjoint sets of [0, count), for components of any kind.
class DisjointSets {
 public:
  explicit DisjointSets(size_t count);
  uint32_t find(uint32_t item);
  void join(uint32_t a, uint32_t b);  // the smaller number leads
  /// Sets numbered from 0 by their first item; gives their number.
  uint32_t number(std::vector<uint32_t>& set_of_item);

 private:
  std::vector<uint32_t> leader_;
};

}  // namespace ohb
