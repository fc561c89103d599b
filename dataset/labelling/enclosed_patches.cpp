#include "dataset/labelling/enclosed_patches.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace ohb::labelling {
namespace {

constexpr float kLargest = 0.01f;      // of the whole area
constexpr float kSurrounded = 0.9f;    // of the border
constexpr float kHue = 12;             // of palms and lips from the skin around, in a* and b*
constexpr float kSole_share = 0.012f;  // of the height: soles lie lower, the middle of a bare foot higher

struct Patch {
  std::vector<uint32_t> faces;
  float area_cm2 = 0, border_cm = 0;
  ClassValues of_class_cm{};  // of the border, by what is beyond
  Vec3f lab, skin_lab;        // sums over the area, and over the border with skin
  float height_cm = 0;        // of the middle

  void add_border(uint8_t part, float length_cm, Vec3f other) {
    border_cm += length_cm;
    of_class_cm[part] += length_cm;
    if (part != kSkin) return;
    skin_lab = skin_lab + length_cm * other;
  }
};

float area_of(const FaceGraph& graph) {
  return std::accumulate(graph.area_cm2.begin(), graph.area_cm2.end(), 0.0f);
}

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
  if (!(patch.of_class_cm[kSkin] > kSurrounded * patch.border_cm) || !(patch.area_cm2 > 0)) return false;
  const Vec3f difference = patch.lab / patch.area_cm2 - patch.skin_lab / patch.of_class_cm[kSkin];
  return std::hypot(difference.y, difference.z) < kHue;
}

bool is_sole(const Patch& patch, const BodyFrame& frame) {
  return frame.is_whole && frame.share_of(patch.height_cm) < kSole_share &&
         patch.of_class_cm[kFabric] > kSurrounded * patch.border_cm;
}

}  // namespace

std::vector<LabelChange> enclosed_labels(const FaceFeatures& features, const std::vector<uint8_t>& face_class,
                                         const std::vector<bool>& is_told) {
  constexpr float kMostlySurrounded = 0.85f;
  const float all_cm2 = area_of(features.graph);
  std::vector<bool> seen(face_class.size(), false);
  std::vector<LabelChange> changes;
  for (uint32_t start = 0; start < face_class.size(); ++start) {
    if (seen[start] || face_class[start] == kSkin) continue;
    const Patch patch = patch_around(features, face_class, start, seen);
    const ClassValues& border_cm = patch.of_class_cm;
    const auto around = static_cast<uint8_t>(std::max_element(border_cm.begin() + kFabric, border_cm.end()) -
                                             border_cm.begin());
    if (patch.area_cm2 > kLargest * all_cm2 || !(border_cm[around] > kMostlySurrounded * patch.border_cm) ||
        std::any_of(patch.faces.begin(), patch.faces.end(), [&](uint32_t f) { return bool(is_told[f]); }))
      continue;
    for (uint32_t f : patch.faces) changes.push_back({f, around});
  }
  return changes;
}

std::vector<PartChange> enclosed_patches(const FaceFeatures& features, const BodyFrame& frame,
                                         const std::vector<uint8_t>& part) {
  const float all_cm2 = area_of(features.graph);
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
