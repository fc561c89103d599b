#include "dataset/labelling/face_features.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace ohb::labelling {
namespace {

constexpr size_t kMostFacesAround = 64;
constexpr float kBridgeLikeness = 0.3f, kCreaseLikeness = 0.5f, kLeastDifference = 2;

/// Mean and spread over the faces around `face` (and itself), weighed by area; the spread within faces
/// counts.
void gather_around(const FaceFeatures& features, uint32_t face, Vec3f& mean, Vec3f& spread) {
  const FaceGraph& graph = features.graph;
  std::vector<uint32_t> around = {face};
  for (size_t i = 0; i < around.size() && around.size() < kMostFacesAround; ++i)
    for (uint32_t n = graph.first_neighbour[around[i]]; n < graph.first_neighbour[around[i] + 1]; ++n) {
      const FaceNeighbour& next = graph.neighbours[n];
      if (graph.edges[next.edge].is_bridge) continue;
      if (length(graph.centre_cm[next.face] - graph.centre_cm[face]) > kTextureRadius_cm) continue;
      if (std::find(around.begin(), around.end(), next.face) == around.end()) around.push_back(next.face);
    }
  double sum[3] = {0, 0, 0}, square[3] = {0, 0, 0}, area = 0;
  for (uint32_t f : around) {
    const double a = double(graph.area_cm2[f]) + 1e-12;
    area += a;
    for (int c = 0; c < 3; ++c) {
      const double lab = features.lab[f][c], own = features.spread[f][c];
      sum[c] += a * lab;
      square[c] += a * (lab * lab + own * own);
    }
  }
  for (int c = 0; c < 3; ++c) {
    const double m = sum[c] / area;
    mean[c] = static_cast<float>(m);
    spread[c] = static_cast<float>(std::sqrt(std::max(0.0, square[c] / area - m * m)));
  }
}

}  // namespace

FaceFeatures face_features(const ScanSurface& surface) {
  FaceFeatures features;
  features.graph = face_graph(surface);
  const std::vector<FaceColour> colours = lab_face_colours(surface.scan);
  const size_t faces = colours.size();
  for (const FaceColour& colour : colours) {
    features.lab.push_back(colour.lab);
    features.spread.push_back(colour.spread);
  }
  features.local_lab.resize(faces);
  features.local_spread.resize(faces);
  features.appearance.resize(faces);
  tbb::parallel_for(size_t{0}, faces, [&](size_t f) {
    gather_around(features, static_cast<uint32_t>(f), features.local_lab[f], features.local_spread[f]);
    features.appearance[f] = Appearance(features.lab[f].x, features.lab[f].y, features.lab[f].z,
                                        std::log(1 + features.local_spread[f].x));
  });
  return features;
}

float median_difference(std::vector<float> differences) {
  if (differences.empty()) return kLeastDifference;
  const auto middle = differences.begin() + static_cast<ptrdiff_t>(differences.size() / 2);
  std::nth_element(differences.begin(), middle, differences.end());
  return std::max(*middle, kLeastDifference);
}

std::vector<float> edge_likeness(const FaceFeatures& features) {
  const FaceGraph& graph = features.graph;
  std::vector<float> difference(graph.edges.size());
  for (size_t e = 0; e < difference.size(); ++e)
    difference[e] = length(features.lab[graph.edges[e].a] - features.lab[graph.edges[e].b]);
  const float median = median_difference(difference);
  std::vector<float> likeness(graph.edges.size());
  for (size_t e = 0; e < likeness.size(); ++e) {
    const FaceEdge& edge = graph.edges[e];
    const Vec3f a = features.spread[edge.a], b = features.spread[edge.b];
    const float variance = median * median + 0.25f * (dot(a, a) + dot(b, b));
    float like = std::exp(-difference[e] * difference[e] / (2 * variance));
    if (edge.fold < 0) like *= 1 - (1 - kCreaseLikeness) * std::min(1.0f, -edge.fold / 0.7f);
    if (edge.is_bridge) like *= kBridgeLikeness;
    likeness[e] = kLeastLikeness + (1 - kLeastLikeness) * like;
  }
  return likeness;
}

}  // namespace ohb::labelling
