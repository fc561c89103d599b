#include "dataset/labelling/soft_borders.h"

#include <algorithm>

namespace ohb::labelling {
namespace {

BorderDistance::Reach half_widths() {
  BorderDistance::Reach half = kBorderWidth_cm;
  for (auto& row : half)
    for (float& width : row) width *= 0.5f;
  return half;
}

std::vector<uint8_t> bits_of(const std::vector<uint8_t>& face_class) {
  std::vector<uint8_t> bits;
  for (uint8_t c : face_class) bits.push_back(c < kClassCount ? static_cast<uint8_t>(1u << c) : uint8_t{0});
  return bits;
}

}  // namespace

SoftBorders::SoftBorders(const Scan& scan, double unit_cm, const std::vector<uint8_t>& face_class)
    : SoftBorders(scan, unit_cm, mesh_topology(scan), face_class) {}

SoftBorders::SoftBorders(const Scan& scan, double unit_cm, const MeshTopology& topology,
                         const std::vector<uint8_t>& face_class)
    : SoftBorders(scan, unit_cm, topology, borders_of_faces(scan, topology, unit_cm, face_class),
                  bits_of(face_class)) {}

SoftBorders::SoftBorders(const Scan& scan, double unit_cm, const MeshTopology& topology,
                         const std::vector<BorderPiece>& pieces, const std::vector<uint8_t>& classes_of_face)
    : unit_cm_(static_cast<float>(unit_cm)),
      distance_(scan, topology, unit_cm, pieces, classes_of_face, half_widths()) {}

ClassValues SoftBorders::shares_at(uint32_t face, uint8_t own, Vec3f at) const {
  ClassValues odds{};  // against the class at the point
  if (own >= kClassCount) return odds;
  const ClassValues away = distance_.distances_at(face, own, at * unit_cm_);
  for (int c = 0; c < kClassCount; ++c) {
    if (c == own) continue;
    const float share = std::max(0.0f, 0.5f - away[c] / kBorderWidth_cm[own][c]);
    odds[c] = share / (1 - share);
  }
  odds[own] = 1;
  const float sum = odds[0] + odds[1] + odds[2] + odds[3];
  for (float& value : odds) value /= sum;
  return odds;
}

}  // namespace ohb::labelling
