#include "dataset/labelling/doubt.h"

#include <algorithm>
#include <cmath>

namespace ohb {
namespace {

uint8_t cheapest_other(const ClassValues& cost, uint8_t than) {
  uint8_t best = kUnlabelled;
  for (uint8_t c = 0; c < kClassCount; ++c)
    if (c != than && (best == kUnlabelled || cost[c] < cost[best])) best = c;
  return best;
}

struct Region {
  std::vector<uint32_t> faces;
  double doubt = 0, area_cm2 = 0;
};

/// The face that most rings of faces separate from the region's outside.
uint32_t middle_of(const FaceGraph& graph, const std::vector<uint32_t>& faces) {
  std::vector<uint8_t> state(graph.size(), 0);  // 0 outside, 1 inside, 2 reached
  for (uint32_t f : faces) state[f] = 1;
  std::vector<uint32_t> reached;
  for (uint32_t f : faces)
    for (uint32_t n = graph.first_neighbour[f]; n < graph.first_neighbour[f + 1] && state[f] == 1; ++n)
      if (state[graph.neighbours[n].face] == 0) {
        state[f] = 2;
        reached.push_back(f);
      }
  for (size_t i = 0; i < reached.size(); ++i)
    for (uint32_t n = graph.first_neighbour[reached[i]]; n < graph.first_neighbour[reached[i] + 1]; ++n) {
      const uint32_t to = graph.neighbours[n].face;
      if (state[to] != 1) continue;
      state[to] = 2;
      reached.push_back(to);
    }
  return reached.empty() ? faces.front() : reached.back();
}

}  // namespace

std::vector<float> confidence_of(const LabelEnergy& energy, const std::vector<float>& area_cm2,
                                 const std::vector<uint8_t>& face_class) {
  std::vector<float> confidence(face_class.size());
  for (size_t f = 0; f < confidence.size(); ++f) {
    const ClassValues& cost = energy.cost[f];
    const float least = *std::min_element(cost.begin(), cost.end()), area = std::max(area_cm2[f], 1e-12f);
    const auto weight = [&](uint8_t c) { return std::exp(-(cost[c] - least) / area); };
    float sum = 0;
    for (uint8_t c = 0; c < kClassCount; ++c) sum += weight(c);
    const float lead = weight(face_class[f]) - weight(cheapest_other(cost, face_class[f]));
    confidence[f] = std::max(0.0f, lead / sum);
  }
  return confidence;
}

std::optional<SuggestedStroke> suggest_stroke(const FaceGraph& graph, const LabelEnergy& energy,
                                              const std::vector<uint8_t>& face_class,
                                              const std::vector<float>& confidence) {
  std::vector<bool> seen(graph.size(), false);
  Region best;
  for (uint32_t start = 0; start < graph.size(); ++start) {
    if (seen[start] || confidence[start] >= kDoubtful) continue;
    Region region;
    region.faces.push_back(start);
    seen[start] = true;
    for (size_t i = 0; i < region.faces.size(); ++i) {
      const uint32_t f = region.faces[i];
      region.area_cm2 += graph.area_cm2[f];
      region.doubt += graph.area_cm2[f] * (1 - confidence[f]);
      for (uint32_t n = graph.first_neighbour[f]; n < graph.first_neighbour[f + 1]; ++n) {
        const uint32_t to = graph.neighbours[n].face;
        if (seen[to] || confidence[to] >= kDoubtful || face_class[to] != face_class[start]) continue;
        seen[to] = true;
        region.faces.push_back(to);
      }
    }
    if (region.doubt > best.doubt) best = std::move(region);
  }
  if (best.faces.empty()) return std::nullopt;
  const uint32_t face = middle_of(graph, best.faces);
  return SuggestedStroke{face, face_class[face], cheapest_other(energy.cost[face], face_class[face]),
                         best.area_cm2};
}

}  // namespace ohb
