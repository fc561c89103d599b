// Minimum cuts. The one file that knows whose solver it is: OpenCV's public header of the algorithm of Boykov
// and Kolmogorov ("An experimental comparison of min-cut/max-flow algorithms", PAMI 2004).
#pragma once

#include <opencv2/core.hpp>
#include <opencv2/imgproc/detail/gcgraph.hpp>

#include <cstddef>
#include <vector>

namespace ohb::labelling {

/// Minimises sum of node terms and pair terms over binary values. Every weight must be >= 0.
class MaxFlow {
 public:
  MaxFlow(size_t nodes, size_t edges)
      : saving_(nodes, 0), graph_(static_cast<unsigned>(nodes), static_cast<unsigned>(2 * edges)) {
    for (size_t i = 0; i < nodes; ++i) graph_.addVtx();
  }
  /// Costs of the node's value being 0 and being 1; may be called more than once a node.
  void add_node(int node, double cost_of_0, double cost_of_1) {
    saving_[node] += cost_of_0 - cost_of_1;
    graph_.addTermWeights(node, cost_of_1, cost_of_0);
  }
  /// Costs of (a, b) being (0, 1), and of being (1, 0).
  void add_edge(int a, int b, double cost_of_01, double cost_of_10) {
    has_edges_ = true;
    graph_.addEdges(a, b, cost_of_01, cost_of_10);
  }
  void solve() {
    if (has_edges_) graph_.maxFlow();  // which takes no graph without edges
  }
  /// After solve(): the node's value in a minimum.
  bool value(int node) { return has_edges_ ? !graph_.inSourceSegment(node) : saving_[node] > 0; }

 private:
  bool has_edges_ = false;
  std::vector<double> saving_;  // of the value 1
  cv::detail::GCGraph<double> graph_;
};

}  // namespace ohb::labelling
