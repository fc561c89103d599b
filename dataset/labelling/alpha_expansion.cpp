#include "dataset/labelling/alpha_expansion.h"

#include <algorithm>
#include <cmath>

#include "dataset/labelling/max_flow.h"

namespace ohb::labelling {
namespace {

/// One expansion as a problem of binary variables: 0 keeps the label, 1 takes the new one.
class Move {
 public:
  Move(const LabelEnergy& energy, uint8_t label, const std::vector<uint8_t>& labels)
      : energy_(energy), label_(label), labels_(labels) {
    for (uint8_t l : labels) variable_.push_back(l == label ? kTaken : variables_++);
  }

  /// Sets the labels to the best ones.
  void solve(std::vector<uint8_t>& labels) {
    MaxFlow flow(variables_, energy_.pairs.size());
    for (size_t n = 0; n < labels.size(); ++n)
      if (variable_[n] != kTaken)
        flow.add_node(variable_[n], energy_.cost[n][labels_[n]], energy_.cost[n][label_]);
    for (const EnergyPair& pair : energy_.pairs) add_pair(pair, flow);
    flow.solve();
    for (size_t n = 0; n < labels.size(); ++n)
      if (variable_[n] != kTaken && flow.value(variable_[n])) labels[n] = label_;
  }

 private:
  static constexpr int kTaken = -1;  // has the label already, so no variable

  void add_pair(const EnergyPair& pair, MaxFlow& flow) const {
    const int a = variable_[pair.a], b = variable_[pair.b];
    const auto& distance = energy_.distance;
    const double weight = pair.weight, c01 = weight * distance[labels_[pair.a]][label_],
                 c10 = weight * distance[label_][labels_[pair.b]];
    if (a != kTaken && b != kTaken) {
      // cost(x, y) = c00 + (c10 - c00 - s) x + (s - c10) y + (c01 + c10 - c00 - s) (1 - x) y + s x (1 - y)
      // for any s, as c11 = 0. This s leaves a pair of one label without costs of nodes, which would be flow
      // for nothing; both last factors are >= 0 for a metric.
      const double c00 = weight * distance[labels_[pair.a]][labels_[pair.b]], s = std::max(0.0, c10 - c00);
      add_gain(flow, a, c10 - c00 - s);
      add_gain(flow, b, s - c10);
      flow.add_edge(a, b, std::max(0.0, c01 + c10 - c00 - s), s);
    } else if (a != kTaken) {
      add_gain(flow, a, -c01);
    } else if (b != kTaken) {
      add_gain(flow, b, -c10);
    }
  }
  /// A cost of the value 1, less that of 0.
  static void add_gain(MaxFlow& flow, int node, double cost) {
    flow.add_node(node, std::max(0.0, -cost), std::max(0.0, cost));
  }

  const LabelEnergy& energy_;
  const uint8_t label_;
  const std::vector<uint8_t> labels_;
  std::vector<int> variable_;
  int variables_ = 0;
};

}  // namespace

double energy_of(const LabelEnergy& energy, const std::vector<uint8_t>& labels) {
  double sum = 0;
  for (size_t n = 0; n < labels.size(); ++n) sum += energy.cost[n][labels[n]];
  for (const EnergyPair& pair : energy.pairs)
    sum += double(pair.weight) * energy.distance[labels[pair.a]][labels[pair.b]];
  return sum;
}

bool expand(const LabelEnergy& energy, uint8_t label, std::vector<uint8_t>& labels) {
  std::vector<uint8_t> moved = labels;
  Move(energy, label, labels).solve(moved);
  if (moved == labels) return false;
  const double before = energy_of(energy, labels), after = energy_of(energy, moved);
  if (!(after < before - 1e-9 * std::abs(before))) return false;
  labels = std::move(moved);
  return true;
}

void minimise(const LabelEnergy& energy, std::vector<uint8_t>& labels, uint8_t first) {
  int idle = 0;  // labels in a row whose expansion brings nothing; one that was just expanded brings no more
  for (int label = first; idle < kClassCount; label = (label + 1) % kClassCount)
    idle = expand(energy, static_cast<uint8_t>(label), labels) ? 1 : idle + 1;
}

}  // namespace ohb::labelling
