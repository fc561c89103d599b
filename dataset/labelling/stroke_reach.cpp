#include "dataset/labelling/stroke_reach.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>

namespace ohb::labelling {
namespace {

constexpr size_t kModes = 8;  // faces of the stroke that stand for it
constexpr float kLeast = 0.01f;
constexpr float kDetour = 0.15f;  // how much a face unlike its neighbour lengthens the way
const Appearance kWidth(8, 5, 5, 0.4f);

std::vector<Appearance> modes_of(const FaceFeatures& features, const std::vector<uint32_t>& faces) {
  std::vector<Appearance> modes;
  const size_t stride = std::max<size_t>(1, faces.size() / kModes);
  for (size_t i = 0; i < faces.size(); i += stride) modes.push_back(features.appearance[faces[i]]);
  return modes;
}

float alike(const Appearance& look, const std::vector<Appearance>& modes) {
  float least = std::numeric_limits<float>::max();
  for (const Appearance& mode : modes)
    least = std::min(least, (look - mode).cwiseQuotient(kWidth).squaredNorm());
  return std::exp(-0.5f * least);
}

}  // namespace

std::vector<StrokeLikeness> reach_of_stroke(const FaceFeatures& features, const std::vector<float>& likeness,
                                            const std::vector<uint8_t>& start_class,
                                            const std::vector<uint32_t>& stroke_faces) {
  using Entry = std::pair<float, uint32_t>;
  const FaceGraph& graph = features.graph;
  const float farthest = -std::log(kLeast) * kStrokeReach_cm;
  const std::vector<Appearance> modes = modes_of(features, stroke_faces);
  std::array<bool, 256> is_open{};  // start classes under the stroke
  for (uint32_t f : stroke_faces) is_open[start_class[f]] = true;
  constexpr float kUnseen = -1;
  std::vector<float> way(graph.size(), std::numeric_limits<float>::max()), look(graph.size(), kUnseen);
  std::priority_queue<Entry, std::vector<Entry>, std::greater<Entry>> open;
  for (uint32_t f : stroke_faces) {
    way[f] = 0;
    open.emplace(0.0f, f);
  }
  const auto is_passable = [&](uint32_t f) {
    if (!is_open[start_class[f]]) return false;
    if (look[f] == kUnseen) look[f] = alike(features.appearance[f], modes);
    return look[f] >= kLeast;
  };
  while (!open.empty()) {
    const auto [length, face] = open.top();
    open.pop();
    if (length > way[face]) continue;
    for (uint32_t n = graph.first_neighbour[face]; n < graph.first_neighbour[face + 1]; ++n) {
      const FaceNeighbour& to = graph.neighbours[n];
      const float next =
          length + graph.edges[to.edge].distance_cm * (1 + kDetour * (1 / likeness[to.edge] - 1));
      if (!(next < way[to.face]) || next > farthest || !is_passable(to.face)) continue;
      way[to.face] = next;
      open.emplace(next, to.face);
    }
  }
  std::vector<StrokeLikeness> reach;
  for (uint32_t f = 0; f < graph.size(); ++f) {
    if (way[f] > farthest) continue;
    const float value = (look[f] == kUnseen ? 1 : look[f]) * std::exp(-way[f] / kStrokeReach_cm);
    if (value >= kLeast) reach.push_back({f, value});
  }
  return reach;
}

}  // namespace ohb::labelling
