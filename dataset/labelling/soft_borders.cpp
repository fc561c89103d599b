#include "dataset/labelling/soft_borders.h"

#include <algorithm>
#include <cmath>

namespace ohb {
namespace {

float squared(Vec3f v) {
  return dot(v, v);
}

Vec3f nearest_on_segment(Vec3f p, Vec3f a, Vec3f b) {
  const Vec3f along = b - a;
  const float length = squared(along);
  return length > 0 ? a + std::clamp(dot(p - a, along) / length, 0.0f, 1.0f) * along : a;
}

/// Squared distance of two segments: from the ends of each to the other; what lies between is nearer only
/// where they cross, which edges of one surface do not.
float squared_distance(Vec3f a, Vec3f b, Vec3f c, Vec3f d) {
  return std::min(
      std::min(squared(a - nearest_on_segment(a, c, d)), squared(b - nearest_on_segment(b, c, d))),
      std::min(squared(c - nearest_on_segment(c, a, b)), squared(d - nearest_on_segment(d, a, b))));
}

}  // namespace

SoftBorders::SoftBorders(const Scan& scan, double unit_cm, const std::vector<uint8_t>& face_class)
    : unit_cm_(static_cast<float>(unit_cm)), face_class_(face_class) {
  const MeshTopology topology = mesh_topology(scan);
  std::vector<Vec3f> point(topology.point_count);
  for (size_t i = 0; i < scan.positions.size(); ++i)
    if (topology.point_of_position[i] != MeshTopology::kNoPoint)
      point[topology.point_of_position[i]] = scan.positions[i] * unit_cm_;
  struct Way {
    uint32_t to, edge;
  };
  std::vector<std::vector<Way>> ways(face_class.size());  // to faces of the same class
  std::vector<std::pair<uint32_t, Piece>> found;          // with the face that it is near
  std::vector<std::pair<uint32_t, Piece>> starts;
  for (uint32_t e = 0; e < topology.edges.size(); ++e) {
    const MeshEdge& edge = topology.edges[e];
    for (uint32_t u = 0; u < edge.use_count; ++u)
      for (uint32_t v = 0; v < edge.use_count; ++v) {
        const uint32_t one = topology.uses[edge.first_use + u].face,
                       other = topology.uses[edge.first_use + v].face;
        if (one == other || face_class[one] >= kClassCount || face_class[other] >= kClassCount) continue;
        if (face_class[one] == face_class[other])
          ways[one].push_back({other, e});
        else
          starts.push_back({one, {point[edge.point[0]], point[edge.point[1]], face_class[other]}});
      }
  }
  // From each piece over the faces of its side, as far as their edges are within half the width.
  std::vector<uint32_t> seen_by(face_class.size(), 0);
  for (uint32_t s = 0; s < starts.size(); ++s) {
    const Piece piece = starts[s].second;
    const float half = 0.5f * kBorderWidth_cm[face_class[starts[s].first]][piece.other];
    std::vector<uint32_t> open = {starts[s].first};
    seen_by[open[0]] = s + 1;
    for (size_t i = 0; i < open.size(); ++i) {
      found.emplace_back(open[i], piece);
      for (const Way& way : ways[open[i]]) {
        if (seen_by[way.to] == s + 1) continue;
        const MeshEdge& edge = topology.edges[way.edge];
        if (squared_distance(piece.a, piece.b, point[edge.point[0]], point[edge.point[1]]) > half * half)
          continue;
        seen_by[way.to] = s + 1;
        open.push_back(way.to);
      }
    }
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& l, const auto& r) { return l.first < r.first; });
  first_.assign(face_class.size() + 1, 0);
  for (const auto& [face, piece] : found) {
    ++first_[face + 1];
    pieces_.push_back(piece);
  }
  for (size_t f = 0; f < face_class.size(); ++f) first_[f + 1] += first_[f];
}

ClassValues SoftBorders::shares_at(uint32_t face, Vec3f at) const {
  const uint8_t own = face_class_[face];
  ClassValues odds{};  // against the face's own class
  if (own >= kClassCount) return odds;
  const Vec3f point = at * unit_cm_;
  for (uint32_t i = first_[face]; i < first_[face + 1]; ++i) {
    const Piece& piece = pieces_[i];
    const float width = kBorderWidth_cm[own][piece.other];
    const float away = length(point - nearest_on_segment(point, piece.a, piece.b));
    const float share = std::max(0.0f, 0.5f - away / width);
    odds[piece.other] = std::max(odds[piece.other], share / (1 - share));
  }
  odds[own] = 1;
  const float sum = odds[0] + odds[1] + odds[2] + odds[3];
  for (float& value : odds) value /= sum;
  return odds;
}

}  // namespace ohb
