#include "dataset/labelling/doubt.h"

#include <algorithm>
#include <cmath>

#include "dataset/labelling/garments.h"

namespace ohb::labelling {
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

}  // namespace

std::vector<float> leads_of(const LabelEnergy& energy, const std::vector<float>& area_cm2,
                            const std::vector<uint8_t>& face_class) {
  std::vector<float> lead(face_class.size());
  for (size_t f = 0; f < lead.size(); ++f) {
    const ClassValues& cost = energy.cost[f];
    const float least = *std::min_element(cost.begin(), cost.end()), area = std::max(area_cm2[f], 1e-12f);
    float own = 0, other = 0;
    for (uint8_t c = 0; c < kClassCount; ++c) {
      const bool is_own = std::min<uint8_t>(c, kFabric) == std::min<uint8_t>(face_class[f], kFabric);
      (is_own ? own : other) += std::exp(-(cost[c] - least) / area);
    }
    lead[f] = std::clamp(std::log((own + 1e-12f) / (other + 1e-12f)), -kMostLead, kMostLead);
  }
  return lead;
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

}  // namespace ohb::labelling
