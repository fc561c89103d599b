#include "dataset/model/mesh_topology.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <unordered_map>

namespace ohb {
namespace {

/// Positions in cells of the welding distance: what may weld lies in the same or a neighbouring cell.
class WeldGrid {
 public:
  WeldGrid(const std::vector<Vec3f>& positions, const Bounds& bounds, double weld_share)
      : positions_(positions), low_(bounds.low), next_(positions.size(), kNone) {
    const double dx = static_cast<double>(bounds.high.x) - low_.x,
                 dy = static_cast<double>(bounds.high.y) - low_.y,
                 dz = static_cast<double>(bounds.high.z) - low_.z;
    distance_ = weld_share * std::sqrt(dx * dx + dy * dy + dz * dz);
    cell_ = std::max(distance_, 1e-300);
  }

  /// The first position seen within the welding distance, or `index` itself.
  uint32_t representative(uint32_t index) {
    const Vec3f p = positions_[index];
    const int64_t x = cell(p.x, low_.x), y = cell(p.y, low_.y), z = cell(p.z, low_.z);
    for (int64_t i = x - 1; i <= x + 1; ++i)
      for (int64_t j = y - 1; j <= y + 1; ++j)
        for (int64_t k = z - 1; k <= z + 1; ++k) {
          const auto found = cells_.find(key(i, j, k));
          if (found == cells_.end()) continue;
          for (uint32_t other = found->second; other != kNone; other = next_[other])
            if (is_close(positions_[other], p)) return other;
        }
    const auto [slot, is_new] = cells_.emplace(key(x, y, z), index);
    if (!is_new) {
      next_[index] = slot->second;
      slot->second = index;
    }
    return index;
  }

 private:
  static constexpr uint32_t kNone = 0xffffffffu;

  int64_t cell(float value, float low) const {
    return static_cast<int64_t>((static_cast<double>(value) - low) / cell_);
  }
  static uint64_t key(int64_t i, int64_t j, int64_t k) {
    uint64_t mixed = static_cast<uint64_t>(i);
    mixed = mixed * 0x9E3779B97F4A7C15ull + static_cast<uint64_t>(j);
    return mixed * 0x9E3779B97F4A7C15ull + static_cast<uint64_t>(k);
  }
  bool is_close(Vec3f a, Vec3f b) const {
    const double dx = static_cast<double>(a.x) - b.x, dy = static_cast<double>(a.y) - b.y,
                 dz = static_cast<double>(a.z) - b.z;
    return dx * dx + dy * dy + dz * dz <= distance_ * distance_;
  }

  const std::vector<Vec3f>& positions_;
  Vec3f low_;
  double distance_ = 0, cell_ = 0;
  std::unordered_map<uint64_t, uint32_t> cells_;
  std::vector<uint32_t> next_;
};

/// Gives each used position its point, in the order of the positions; returns the number of points.
uint32_t weld(const Scan& scan, double weld_share, std::vector<uint32_t>& point_of_position) {
  constexpr uint32_t kNone = MeshTopology::kNoPoint, kUsed = kNone - 1;
  point_of_position.assign(scan.positions.size(), kNone);
  for (const Corner& corner : scan.corners) point_of_position[corner.position] = kUsed;
  WeldGrid grid(scan.positions, bounds_of_faces(scan), weld_share);
  uint32_t count = 0;
  for (uint32_t i = 0; i < scan.positions.size(); ++i) {
    if (point_of_position[i] == kNone) continue;
    const uint32_t first = grid.representative(i);
    point_of_position[i] = first == i ? count++ : point_of_position[first];
  }
  return count;
}

struct HalfEdge {
  uint32_t a, b, face;
  bool forward;
};

std::vector<HalfEdge> half_edges(const Scan& scan, const std::vector<uint32_t>& point) {
  std::vector<HalfEdge> halves;
  halves.reserve(scan.corners.size());
  for (uint32_t f = 0; f < scan.face_count(); ++f) {
    const uint32_t begin = scan.face_begin[f], end = scan.face_begin[f + 1];
    for (uint32_t c = begin; c < end; ++c) {
      const uint32_t from = point[scan.corners[c].position];
      const uint32_t to = point[scan.corners[c + 1 < end ? c + 1 : begin].position];
      if (from != to) halves.push_back({std::min(from, to), std::max(from, to), f, from < to});
    }
  }
  std::stable_sort(halves.begin(), halves.end(),
                   [](const HalfEdge& l, const HalfEdge& r) { return l.a != r.a ? l.a < r.a : l.b < r.b; });
  return halves;
}

}  // namespace

Bounds bounds_of_faces(const Scan& scan) {
  std::vector<Vec3f> used;
  used.reserve(scan.corners.size());
  for (const Corner& corner : scan.corners) used.push_back(scan.positions[corner.position]);
  return bounds_of(used);
}

DisjointSets::DisjointSets(size_t count) : leader_(count) {
  std::iota(leader_.begin(), leader_.end(), 0u);
}

uint32_t DisjointSets::find(uint32_t item) {
  while (leader_[item] != item) item = leader_[item] = leader_[leader_[item]];
  return item;
}

void DisjointSets::join(uint32_t a, uint32_t b) {
  a = find(a);
  b = find(b);
  leader_[std::max(a, b)] = std::min(a, b);
}

uint32_t DisjointSets::number(std::vector<uint32_t>& set_of_item) {
  set_of_item.resize(leader_.size());
  uint32_t count = 0;
  for (uint32_t i = 0; i < leader_.size(); ++i) {
    const uint32_t leader = find(i);  // never after i
    set_of_item[i] = leader == i ? count++ : set_of_item[leader];
  }
  return count;
}

MeshTopology mesh_topology(const Scan& scan, double weld_share) {
  MeshTopology topology;
  topology.point_count = weld(scan, weld_share, topology.point_of_position);
  DisjointSets components(scan.face_count());
  for (const HalfEdge& half : half_edges(scan, topology.point_of_position)) {
    const auto use = static_cast<uint32_t>(topology.uses.size());
    const bool is_new = topology.edges.empty() || topology.edges.back().point[0] != half.a ||
                        topology.edges.back().point[1] != half.b;
    if (is_new) topology.edges.push_back({{half.a, half.b}, use, 0});
    ++topology.edges.back().use_count;
    topology.uses.push_back({half.face, half.forward});
    components.join(topology.uses[topology.edges.back().first_use].face, half.face);
  }
  topology.component_count = components.number(topology.component_of_face);
  return topology;
}

}  // namespace ohb
