#include "dataset/labelling/face_graph.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace ohb::labelling {
namespace {

void measure_faces(const Scan& scan, float unit_cm, FaceGraph& graph) {
  const size_t faces = scan.face_count();
  graph.centre_cm.resize(faces);
  graph.normal.resize(faces);
  graph.area_cm2.resize(faces);
  for (size_t f = 0; f < faces; ++f) {
    const uint32_t begin = scan.face_begin[f], end = scan.face_begin[f + 1];
    const Vec3f origin = scan.positions[scan.corners[begin].position];
    Vec3f sum, twice_area;  // of the polygon: the sum of its fan's cross products
    for (uint32_t c = begin; c < end; ++c) {
      const Vec3f p = scan.positions[scan.corners[c].position] - origin;
      const Vec3f next = scan.positions[scan.corners[c + 1 < end ? c + 1 : begin].position] - origin;
      sum += p;
      twice_area += cross(p, next);
    }
    graph.centre_cm[f] = (origin + sum / static_cast<float>(end - begin)) * unit_cm;
    graph.area_cm2[f] = 0.5f * length(twice_area) * unit_cm * unit_cm;
    graph.normal[f] = normalised(twice_area);
  }
}

float fold_between(const FaceGraph& graph, uint32_t a, uint32_t b) {
  const Vec3f turn = graph.normal[b] - graph.normal[a];
  const float ridge = dot(turn, graph.centre_cm[b] - graph.centre_cm[a]);
  return std::copysign(0.5f * length(turn), ridge);
}

void add_shared_edges(const MeshTopology& topology, const std::vector<Vec3f>& points, FaceGraph& graph) {
  for (const MeshEdge& edge : topology.edges) {
    if (edge.use_count > 2) ++graph.non_manifold_edges;
    const Vec3f p = points[edge.point[0]], q = points[edge.point[1]];
    for (uint32_t u = 1; u < edge.use_count; ++u) {
      const uint32_t one = topology.uses[edge.first_use + u - 1].face;
      const uint32_t other = topology.uses[edge.first_use + u].face;
      if (one == other) continue;
      const uint32_t a = std::min(one, other), b = std::max(one, other);
      const Vec3f middle = 0.5f * (p + q);
      const float border = length(p - q);
      const float distance = length(graph.centre_cm[a] - middle) + length(graph.centre_cm[b] - middle);
      graph.edges.push_back(
          {a, b, border, std::max(distance, 0.01f * border), fold_between(graph, a, b), false});
    }
  }
}

/// Points in cubes of the bridges' reach.
class PointGrid {
 public:
  explicit PointGrid(const std::vector<Vec3f>& points) : points_(points) {
    for (uint32_t i = 0; i < points.size(); ++i) cells_[key_of(points[i], 0, 0, 0)].push_back(i);
  }
  /// Calls visit(index, squared distance) for each point within reach.
  template <typename Visit>
  void near(Vec3f p, const Visit& visit) const {
    for (int i = -1; i <= 1; ++i)
      for (int j = -1; j <= 1; ++j)
        for (int k = -1; k <= 1; ++k) {
          const auto found = cells_.find(key_of(p, i, j, k));
          if (found == cells_.end()) continue;
          for (uint32_t other : found->second) {
            const Vec3f away = points_[other] - p;
            const float squared = dot(away, away);
            if (squared <= kBridgeReach_cm * kBridgeReach_cm) visit(other, squared);
          }
        }
  }

 private:
  static uint64_t key_of(Vec3f p, int i, int j, int k) {
    const auto cell = [](float v, int shift) {
      return static_cast<uint64_t>(static_cast<int64_t>(std::floor(v / kBridgeReach_cm)) + shift);
    };
    return (cell(p.x, i) * 0x9E3779B97F4A7C15ull + cell(p.y, j)) * 0x9E3779B97F4A7C15ull + cell(p.z, k);
  }
  const std::vector<Vec3f>& points_;
  std::unordered_map<uint64_t, std::vector<uint32_t>> cells_;
};

/// For each point a face of its own, the faces around it counted, and a third of their area.
struct PointFaces {
  std::vector<uint32_t> face;
  std::vector<float> area_cm2;
};

PointFaces faces_of_points(const ScanSurface& surface, const FaceGraph& graph) {
  const Scan& scan = surface.scan;
  const MeshTopology& topology = surface.topology;
  PointFaces of;
  of.face.assign(topology.point_count, MeshTopology::kNoPoint);
  of.area_cm2.assign(topology.point_count, 0);
  for (uint32_t f = 0; f < graph.size(); ++f) {
    const uint32_t begin = scan.face_begin[f], end = scan.face_begin[f + 1];
    for (uint32_t c = begin; c < end; ++c) {
      const uint32_t point = topology.point_of_position[scan.corners[c].position];
      if (of.face[point] == MeshTopology::kNoPoint) of.face[point] = f;
      of.area_cm2[point] += graph.area_cm2[f] / static_cast<float>(end - begin);
    }
  }
  return of;
}

void add_bridges(const ScanSurface& surface, const std::vector<Vec3f>& points, FaceGraph& graph) {
  if (graph.component_count < 2) return;
  const PointFaces of = faces_of_points(surface, graph);
  const PointGrid grid(points);
  for (uint32_t p = 0; p < points.size(); ++p) {
    const uint32_t component = graph.component[of.face[p]];
    uint32_t nearest = MeshTopology::kNoPoint;
    float least = 0;
    grid.near(points[p], [&](uint32_t other, float squared) {
      if (graph.component[of.face[other]] == component) return;
      if (nearest != MeshTopology::kNoPoint && (squared > least || (squared == least && other > nearest)))
        return;
      nearest = other;
      least = squared;
    });
    if (nearest == MeshTopology::kNoPoint) continue;
    const uint32_t a = std::min(of.face[p], of.face[nearest]), b = std::max(of.face[p], of.face[nearest]);
    const auto reach = static_cast<float>(kBridgeReach_cm);
    graph.edges.push_back({a, b, of.area_cm2[p] / reach, reach, 0, true});
  }
}

/// Sorted, pairs that occur more than once joined into one.
void merge_edges(std::vector<FaceEdge>& edges) {
  std::stable_sort(edges.begin(), edges.end(),
                   [](const FaceEdge& l, const FaceEdge& r) { return l.a != r.a ? l.a < r.a : l.b < r.b; });
  size_t kept = 0;
  for (const FaceEdge& edge : edges) {
    if (kept > 0 && edges[kept - 1].a == edge.a && edges[kept - 1].b == edge.b)
      edges[kept - 1].length_cm += edge.length_cm;
    else
      edges[kept++] = edge;
  }
  edges.resize(kept);
}

void list_neighbours(FaceGraph& graph) {
  graph.first_neighbour.assign(graph.size() + 1, 0);
  for (const FaceEdge& edge : graph.edges) {
    ++graph.first_neighbour[edge.a + 1];
    ++graph.first_neighbour[edge.b + 1];
    graph.bridge_count += edge.is_bridge;
  }
  for (size_t f = 0; f < graph.size(); ++f) graph.first_neighbour[f + 1] += graph.first_neighbour[f];
  graph.neighbours.resize(2 * graph.edges.size());
  std::vector<uint32_t> next(graph.first_neighbour.begin(), graph.first_neighbour.end() - 1);
  for (uint32_t e = 0; e < graph.edges.size(); ++e) {
    graph.neighbours[next[graph.edges[e].a]++] = {graph.edges[e].b, e};
    graph.neighbours[next[graph.edges[e].b]++] = {graph.edges[e].a, e};
  }
}

}  // namespace

FaceGraph face_graph(const ScanSurface& surface) {
  const MeshTopology& topology = surface.topology;
  const std::vector<Vec3f> points = surface.points_cm();
  FaceGraph graph;
  measure_faces(surface.scan, static_cast<float>(surface.unit_cm), graph);
  graph.component = topology.component_of_face;
  graph.component_count = topology.component_count;
  add_shared_edges(topology, points, graph);
  add_bridges(surface, points, graph);
  merge_edges(graph.edges);
  list_neighbours(graph);
  return graph;
}

}  // namespace ohb::labelling
