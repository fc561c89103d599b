#include "dataset/labelling/enclosed_patches.h"

#include <cmath>

namespace ohb::labelling {
namespace {

constexpr float kLargest = 0.01f;      // of the whole area
constexpr float kSurrounded = 0.9f;    // of the border
constexpr float kHue = 12;             // of palms and lips from the skin around, in a* and b*
constexpr float kSole_share = 0.012f;  // of the height: soles lie lower, the middle of a bare foot higher

struct Patch {
  std::vector<uint32_t> faces;
  float area_cm2 = 0, border_cm = 0;
  float skin_cm = 0, cloth_cm = 0;  // of the border
  Vec3f lab, skin_lab;              // sums over the area, and over the border with skin
  float height_cm = 0;              // of the middle

  void add_border(uint8_t part, float length_cm, Vec3f other) {
    border_cm += length_cm;
    if (part == kFabric) cloth_cm += length_cm;
    if (part != kSkin) return;
    skin_cm += length_cm;
    skin_lab = skin_lab + length_cm * other;
  }
};

Patch patch_around(const FaceFeatures& features, const std::vector<uint8_t>& part, uint32_t start,
                   std::vector<bool>& seen) {
  const FaceGraph& graph = features.graph;
  Patch patch;
  patch.faces.push_back(start);
  seen[start] = true;
  for (size_t i = 0; i < patch.faces.size(); ++i) {
    const uint32_t f = patch.faces[i];
    const float area = graph.area_cm2[f];
    patch.area_cm2 += area;
    patch.lab = patch.lab + area * features.lab[f];
    patch.height_cm += area * graph.centre_cm[f].y;
    for (uint32_t n = graph.first_neighbour[f]; n < graph.first_neighbour[f + 1]; ++n) {
      const FaceNeighbour& to = graph.neighbours[n];
      if (part[to.face] != part[start]) {
        patch.add_border(part[to.face], graph.edges[to.edge].length_cm, features.lab[to.face]);
      } else if (!seen[to.face]) {
        seen[to.face] = true;
        patch.faces.push_back(to.face);
      }
    }
  }
  patch.height_cm /= std::max(patch.area_cm2, 1e-6f);
  return patch;
}

bool is_skin(const Patch& patch) {
  if (!(patch.skin_cm > kSurrounded * patch.border_cm) || !(patch.area_cm2 > 0)) return false;
  const Vec3f difference = patch.lab / patch.area_cm2 - patch.skin_lab / patch.skin_cm;
  return std::hypot(difference.y, difference.z) < kHue;
}

bool is_sole(const Patch& patch, const BodyFrame& frame) {
  return frame.is_whole && frame.share_of(patch.height_cm) < kSole_share &&
         patch.cloth_cm > kSurrounded * patch.border_cm;
}

}  // namespace

std::vector<PartChange> enclosed_patches(const FaceFeatures& features, const BodyFrame& frame,
                                         const std::vector<uint8_t>& part) {
  float all_cm2 = 0;
  for (float area : features.graph.area_cm2) all_cm2 += area;
  std::vector<bool> seen(part.size(), false);
  std::vector<PartChange> changes;
  for (uint32_t start = 0; start < part.size(); ++start) {
    if (seen[start] || part[start] == kHair) continue;
    const Patch patch = patch_around(features, part, start, seen);
    if (patch.area_cm2 > kLargest * all_cm2) continue;
    if (part[start] == kFabric ? !is_skin(patch) : !is_sole(patch, frame)) continue;
    for (uint32_t f : patch.faces) changes.push_back({f, part[start] == kFabric ? kSkin : kFabric});
  }
  return changes;
}

}  // namespace ohb::labelling
