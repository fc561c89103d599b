#include "tests/bench/robot_user.h"

#include <algorithm>
#include <limits>
#include <queue>

namespace ohb {
using namespace labelling;
namespace {

constexpr float kFar = std::numeric_limits<float>::max();
constexpr float kLongestStroke_cm = 6, kThinnest_cm = 0.2f, kBroadest_cm = 1.5f;

struct Walk {
  std::vector<float> distance_cm;
  std::vector<uint32_t> from;  // the face before; itself at a start
};

/// Shortest ways from the starts over the faces that `is_open` lets through.
template <typename IsOpen>
Walk shortest_ways(const FaceGraph& graph, const std::vector<std::pair<uint32_t, float>>& starts,
                   const IsOpen& is_open) {
  using Entry = std::pair<float, uint32_t>;
  Walk walk{std::vector<float>(graph.size(), kFar), std::vector<uint32_t>(graph.size(), 0)};
  std::priority_queue<Entry, std::vector<Entry>, std::greater<Entry>> open;
  for (const auto& [face, distance] : starts) {
    if (distance >= walk.distance_cm[face]) continue;
    walk.distance_cm[face] = distance;
    walk.from[face] = face;
    open.emplace(distance, face);
  }
  while (!open.empty()) {
    const auto [distance, face] = open.top();
    open.pop();
    if (distance > walk.distance_cm[face]) continue;
    for (uint32_t n = graph.first_neighbour[face]; n < graph.first_neighbour[face + 1]; ++n) {
      const FaceNeighbour& to = graph.neighbours[n];
      const float next = distance + graph.edges[to.edge].distance_cm;
      if (!is_open(to.face) || !(next < walk.distance_cm[to.face])) continue;
      walk.distance_cm[to.face] = next;
      walk.from[to.face] = face;
      open.emplace(next, to.face);
    }
  }
  return walk;
}

/// The faces of the largest connected region that is wrong; all of one true class.
std::vector<uint32_t> largest_error(const FaceGraph& graph, const std::vector<uint8_t>& face_class,
                                    const std::vector<uint8_t>& truth) {
  std::vector<bool> seen(graph.size(), false);
  std::vector<uint32_t> largest;
  double most = 0;
  for (uint32_t start = 0; start < graph.size(); ++start) {
    if (seen[start] || face_class[start] == truth[start] || truth[start] >= kClassCount) continue;
    std::vector<uint32_t> region = {start};
    seen[start] = true;
    double area = 0;
    for (size_t i = 0; i < region.size(); ++i) {
      area += graph.area_cm2[region[i]];
      for (uint32_t n = graph.first_neighbour[region[i]]; n < graph.first_neighbour[region[i] + 1]; ++n) {
        const uint32_t to = graph.neighbours[n].face;
        if (seen[to] || face_class[to] == truth[to] || truth[to] != truth[start]) continue;
        seen[to] = true;
        region.push_back(to);
      }
    }
    if (area <= most) continue;
    most = area;
    largest = std::move(region);
  }
  return largest;
}

/// Of a face and its neighbours the one whose centre is nearest.
uint32_t nearest_around(const FaceGraph& graph, uint32_t face, Vec3f at) {
  uint32_t nearest = face;
  for (uint32_t n = graph.first_neighbour[face]; n < graph.first_neighbour[face + 1]; ++n) {
    const uint32_t to = graph.neighbours[n].face;
    if (length(graph.centre_cm[to] - at) < length(graph.centre_cm[nearest] - at)) nearest = to;
  }
  return nearest;
}

}  // namespace

Stroke next_stroke(const FaceGraph& graph, double unit_cm, const std::vector<uint8_t>& face_class,
                   const std::vector<uint8_t>& truth, const RobotNoise& noise, std::mt19937& random) {
  Stroke stroke;
  const std::vector<uint32_t> region = largest_error(graph, face_class, truth);
  if (region.empty()) return stroke;
  std::vector<bool> is_in(graph.size(), false);
  for (uint32_t f : region) is_in[f] = true;
  // Depth: the way to the nearest face outside, or to an open border of the mesh (a face's own size).
  std::vector<std::pair<uint32_t, float>> border;
  for (uint32_t f : region)
    for (uint32_t n = graph.first_neighbour[f]; n < graph.first_neighbour[f + 1]; ++n)
      if (!is_in[graph.neighbours[n].face])
        border.emplace_back(f, 0.5f * graph.edges[graph.neighbours[n].edge].distance_cm);
  if (border.empty()) border.emplace_back(region.front(), 0.0f);
  const auto inside = [&](uint32_t f) { return bool(is_in[f]); };
  const Walk depth = shortest_ways(graph, border, inside);
  const auto shallower = [&](uint32_t l, uint32_t r) { return depth.distance_cm[l] < depth.distance_cm[r]; };
  const uint32_t middle = *std::max_element(region.begin(), region.end(), shallower);
  const float deepest = depth.distance_cm[middle];
  const auto is_deep = [&](uint32_t f) { return is_in[f] && depth.distance_cm[f] >= 0.5f * deepest; };
  const Walk line = shortest_ways(graph, {{middle, 0.0f}}, is_deep);
  uint32_t end = middle;
  for (uint32_t f : region)
    if (line.distance_cm[f] <= kLongestStroke_cm && line.distance_cm[f] > line.distance_cm[end]) end = f;
  std::uniform_real_distribution<double> share(0, 1);
  stroke.material_class = static_cast<MaterialClass>(truth[middle]);
  if (share(random) < noise.wrong_share)
    stroke.material_class =
        static_cast<MaterialClass>((stroke.material_class + 1 + static_cast<int>(share(random) * 3) % 3) % 4);
  stroke.radius_cm = std::clamp(0.5f * deepest, kThinnest_cm, kBroadest_cm);
  for (uint32_t f = end;; f = line.from[f]) {
    Vec3f at = graph.centre_cm[f];
    if (noise.jitter_cm > 0)
      for (int i = 0; i < 3; ++i) at[i] += static_cast<float>((2 * share(random) - 1) * noise.jitter_cm);
    stroke.points.push_back({nearest_around(graph, f, at), at / static_cast<float>(unit_cm)});
    if (f == middle) break;
  }
  return stroke;
}

std::vector<uint8_t> nearest_stroke_classes(const FaceGraph& graph, double unit_cm,
                                            const std::vector<Stroke>& strokes,
                                            const std::vector<uint8_t>& otherwise) {
  if (strokes.empty()) return otherwise;
  const StrokedFaces stroked = stroked_faces(strokes, graph, unit_cm);
  std::vector<std::pair<uint32_t, float>> starts;
  std::vector<uint8_t> face_class(graph.size(), kUnlabelled);
  for (size_t i = 0; i < stroked.face.size(); ++i) {
    starts.emplace_back(stroked.face[i], 0.0f);
    face_class[stroked.face[i]] = stroked.material_class[i];
  }
  const Walk walk = shortest_ways(graph, starts, [](uint32_t) { return true; });
  for (uint32_t f = 0; f < graph.size(); ++f) {
    uint32_t at = f;
    while (walk.distance_cm[f] < kFar && face_class[at] == kUnlabelled) at = walk.from[at];
    face_class[f] = walk.distance_cm[f] < kFar ? face_class[at] : otherwise[f];
  }
  return face_class;
}

}  // namespace ohb
