#include "dataset/labelling/soft_borders.h"

#include <algorithm>
#include <numeric>

namespace ohb::labelling {
namespace {

BorderDistance::Reach half_widths() {
  BorderDistance::Reach half = kBorderWidth_cm;
  for (auto& row : half)
    for (float& width : row) width *= 0.5f;
  return half;
}

}  // namespace

SoftBorders::SoftBorders(const ScanSurface& surface, const std::vector<uint8_t>& face_class)
    : SoftBorders(surface, borders_of_faces(surface, face_class), class_bits(face_class)) {}

SoftBorders::SoftBorders(const ScanSurface& surface, const std::vector<BorderPiece>& pieces,
                         const std::vector<uint8_t>& classes_of_face)
    : unit_cm_(static_cast<float>(surface.unit_cm)),
      distance_(surface, pieces, classes_of_face, half_widths()) {}

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
  const float sum = std::accumulate(odds.begin(), odds.end(), 0.0f);
  for (float& value : odds) value /= sum;
  return odds;
}

}  // namespace ohb::labelling
