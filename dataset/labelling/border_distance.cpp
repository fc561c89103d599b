#include "dataset/labelling/border_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ohb::labelling {
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

/// Calls visit(edge, one face, other face) for each pair of faces at each edge, in both orders.
template <typename Visit>
void each_meeting(const MeshTopology& topology, const Visit& visit) {
  for (uint32_t e = 0; e < topology.edges.size(); ++e) {
    const MeshEdge& edge = topology.edges[e];
    for (uint32_t u = 0; u < edge.use_count; ++u)
      for (uint32_t v = 0; v < edge.use_count; ++v) {
        const uint32_t one = topology.uses[edge.first_use + u].face,
                       other = topology.uses[edge.first_use + v].face;
        if (one != other) visit(e, one, other);
      }
  }
}

}  // namespace

std::vector<BorderPiece> borders_of_faces(const ScanSurface& surface,
                                          const std::vector<uint8_t>& face_class) {
  const std::vector<Vec3f> point = surface.points_cm();
  std::vector<BorderPiece> pieces;
  each_meeting(surface.topology, [&](uint32_t e, uint32_t one, uint32_t other) {
    const uint8_t own = face_class[one], beyond = face_class[other];
    if (own == beyond || own >= kClassCount || beyond >= kClassCount) return;
    const MeshEdge& edge = surface.topology.edges[e];
    pieces.push_back({one, other, own, beyond, point[edge.point[0]], point[edge.point[1]]});
  });
  return pieces;
}

std::vector<uint8_t> class_bits(const std::vector<uint8_t>& face_class) {
  std::vector<uint8_t> bits;
  bits.reserve(face_class.size());
  for (uint8_t c : face_class) bits.push_back(c < kClassCount ? static_cast<uint8_t>(1u << c) : uint8_t{0});
  return bits;
}

BorderDistance::BorderDistance(const ScanSurface& surface, const std::vector<BorderPiece>& pieces,
                               const std::vector<uint8_t>& classes_of_face, const Reach& reach_cm) {
  const std::vector<Vec3f> point = surface.points_cm();
  struct Way {
    uint32_t to, edge;
  };
  std::vector<std::vector<Way>> ways(classes_of_face.size());
  each_meeting(surface.topology, [&](uint32_t e, uint32_t one, uint32_t other) {
    if (classes_of_face[one] & classes_of_face[other]) ways[one].push_back({other, e});
  });
  // From each piece over the faces of its side, as far as their edges are within reach.
  std::vector<std::pair<uint32_t, uint32_t>> found;  // face and piece
  std::vector<uint32_t> seen_by(classes_of_face.size(), 0), open;
  for (uint32_t p = 0; p < pieces.size(); ++p) {
    const BorderPiece& piece = pieces[p];
    const float reach = reach_cm[piece.own][piece.other];
    open = {piece.face};
    seen_by[piece.face] = p + 1;
    for (size_t i = 0; i < open.size(); ++i) {
      found.emplace_back(open[i], p);
      for (const Way& way : ways[open[i]]) {
        if (seen_by[way.to] == p + 1 || !(classes_of_face[way.to] >> piece.own & 1)) continue;
        const MeshEdge& edge = surface.topology.edges[way.edge];
        if (squared_distance(piece.a, piece.b, point[edge.point[0]], point[edge.point[1]]) > reach * reach)
          continue;
        seen_by[way.to] = p + 1;
        open.push_back(way.to);
      }
    }
  }
  first_.assign(classes_of_face.size() + 1, 0);
  for (const auto& [face, piece] : found) ++first_[face + 1];
  for (size_t f = 0; f < classes_of_face.size(); ++f) first_[f + 1] += first_[f];
  std::vector<uint32_t> next(first_.begin(), first_.end() - 1);
  pieces_.resize(found.size());
  for (const auto& [face, piece] : found) pieces_[next[face]++] = pieces[piece];
}

ClassValues BorderDistance::distances_at(uint32_t face, uint8_t own, Vec3f point_cm) const {
  ClassValues nearest;
  nearest.fill(std::numeric_limits<float>::infinity());
  for (uint32_t i = first_[face]; i < first_[face + 1]; ++i) {
    const BorderPiece& piece = pieces_[i];
    if (piece.own != own) continue;
    const float away = squared(point_cm - nearest_on_segment(point_cm, piece.a, piece.b));
    nearest[piece.other] = std::min(nearest[piece.other], away);
  }
  for (float& distance : nearest) distance = std::sqrt(distance);
  return nearest;
}

}  // namespace ohb::labelling
