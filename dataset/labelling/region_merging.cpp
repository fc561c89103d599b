#include "dataset/labelling/region_merging.h"

#include <algorithm>
#include <numeric>
#include <tuple>

#include "dataset/labelling/garments.h"

namespace ohb::labelling {

RegionMerging::RegionMerging(const FaceGraph& graph, const std::vector<float>& likeness,
                             const std::vector<bool>& is_in, const std::vector<Appearance>& look)
    : parent_(graph.size()),
      version_(graph.size(), 0),
      area_(graph.size()),
      look_sum_(graph.size()),
      border_cm_(graph.size()) {
  std::iota(parent_.begin(), parent_.end(), 0u);
  for (size_t f = 0; f < graph.size(); ++f) {
    area_[f] = graph.area_cm2[f] + 1e-6f;
    look_sum_[f] = area_[f] * look[f];
  }
  for (size_t e = 0; e < graph.edges.size(); ++e) {
    const FaceEdge& edge = graph.edges[e];
    if (!is_in[edge.a] || !is_in[edge.b]) continue;
    const float border_cm = edge.length_cm * likeness[e] + 1e-6f;
    border_cm_[edge.a][edge.b] += border_cm;
    border_cm_[edge.b][edge.a] += border_cm;
  }
  for (uint32_t f = 0; f < graph.size(); ++f)
    for (const auto& [other, border_cm] : border_cm_[f])
      if (f < other) propose(f, other, border_cm);
}

float RegionMerging::cost(uint32_t a, uint32_t b, float border_cm) const {
  return area_[a] * area_[b] / (area_[a] + area_[b]) * look_difference(look(a), look(b)) / border_cm;
}

void RegionMerging::propose(uint32_t a, uint32_t b, float border_cm) {
  if (a > b) std::swap(a, b);
  open_.push({cost(a, b, border_cm), a, b, version_[a], version_[b]});
}

uint32_t RegionMerging::region_of(uint32_t face) {
  while (parent_[face] != face) face = parent_[face] = parent_[parent_[face]];
  return face;
}

/// Into the one with more neighbours, so that all merges together move each border few times.
uint32_t RegionMerging::merge(uint32_t a, uint32_t b) {
  if (border_cm_[a].size() < border_cm_[b].size()) std::swap(a, b);
  parent_[b] = a;
  ++version_[a];
  area_[a] += area_[b];
  look_sum_[a] += look_sum_[b];
  border_cm_[a].erase(b);
  for (const auto& [other, border_cm] : border_cm_[b]) {
    if (other == a) continue;
    border_cm_[other].erase(b);
    const float sum = border_cm_[a][other] += border_cm;
    border_cm_[other][a] = sum;
    propose(a, other, sum);
  }
  border_cm_[b].clear();
  return a;
}

void RegionMerging::merge_below(float most_cm) {
  while (!open_.empty() && open_.top().cost < most_cm) {
    const Pair pair = open_.top();
    open_.pop();
    if (parent_[pair.a] != pair.a || parent_[pair.b] != pair.b) continue;
    const auto border = border_cm_[pair.a].find(pair.b);
    if (border == border_cm_[pair.a].end()) continue;
    if (version_[pair.a] == pair.version_a && version_[pair.b] == pair.version_b)
      merge(pair.a, pair.b);
    else  // one of them grew since: the cost is another
      propose(pair.a, pair.b, border->second);
  }
}

void RegionMerging::merge_crumbs(float least_cm2) {
  std::vector<uint32_t> crumbs;
  for (uint32_t r = 0; r < parent_.size(); ++r)
    if (parent_[r] == r && area_[r] < least_cm2 && !border_cm_[r].empty()) crumbs.push_back(r);
  std::stable_sort(crumbs.begin(), crumbs.end(), [&](uint32_t l, uint32_t r) { return area_[l] < area_[r]; });
  for (uint32_t crumb : crumbs) {
    const uint32_t r = region_of(crumb);
    if (area_[r] >= least_cm2 || border_cm_[r].empty()) continue;
    uint32_t best = border_cm_[r].begin()->first;
    for (const auto& [other, border_cm] : border_cm_[r])
      if (cost(r, other, border_cm) < cost(r, best, border_cm_[r][best])) best = other;
    merge(r, best);
  }
}

}  // namespace ohb::labelling
