#include "dataset/labelling/alpha_expansion.h"

#include <algorithm>
#include <cmath>

#include "dataset/labelling/max_flow.h"

namespace ohb {
namespace {

constexpr int kKept = -1, kTaken = -2;  // nodes without a variable: what they do is known

/// One expansion as a problem of binary variables: 0 keeps the label, 1 takes the new one.
class Move {
 public:
  Move(const LabelEnergy& energy, uint8_t label, const std::vector<uint8_t>& labels)
      : energy_(energy), label_(label), labels_(labels) {
    decide_nodes();
  }

  /// Sets the labels to the best ones.
  void solve(std::vector<uint8_t>& labels) {
    MaxFlow flow(variables_, energy_.pairs.size());
    for (size_t n = 0; n < labels.size(); ++n)
      if (variable_[n] >= 0)
        flow.add_node(variable_[n], energy_.cost[n][labels_[n]], energy_.cost[n][label_]);
    for (const EnergyPair& pair : energy_.pairs) add_pair(pair, flow);
    flow.solve();
    for (size_t n = 0; n < labels.size(); ++n)
      if (variable_[n] == kTaken || (variable_[n] >= 0 && flow.value(variable_[n]))) labels[n] = label_;
  }

 private:
  /// A node whose own costs differ by more than its pairs can ever pay for has no variable: it does the
  /// cheaper thing in every minimum.
  void decide_nodes() {
    float longest = 0;
    for (const auto& row : energy_.distance)
      longest = std::max(longest, *std::max_element(row.begin(), row.end()));
    std::vector<double> at_stake(labels_.size(), 0);
    for (const EnergyPair& pair : energy_.pairs) {
      at_stake[pair.a] += double(pair.weight) * longest;
      at_stake[pair.b] += double(pair.weight) * longest;
    }
    variable_.resize(labels_.size());
    for (size_t n = 0; n < labels_.size(); ++n) {
      const double gain = double(energy_.cost[n][labels_[n]]) - energy_.cost[n][label_];
      const double least = at_stake[n] * (1 + 1e-9) + 1e-30;
      if (labels_[n] == label_ || gain < -least)
        variable_[n] = kKept;
      else
        variable_[n] = gain > least ? kTaken : variables_++;
    }
  }

  uint8_t label_after(uint32_t node, bool takes) const { return takes ? label_ : labels_[node]; }
  double cost_of(const EnergyPair& pair, bool a_takes, bool b_takes) const {
    return double(pair.weight) * energy_.distance[label_after(pair.a, a_takes)][label_after(pair.b, b_takes)];
  }

  void add_pair(const EnergyPair& pair, MaxFlow& flow) const {
    const int a = variable_[pair.a], b = variable_[pair.b];
    if (a >= 0 && b >= 0) {
      // cost(x, y) = c00 + (c10 - c00) x + (c11 - c10) y + (c01 + c10 - c00 - c11) (1 - x) y; the last factor
      // is >= 0 for a metric.
      const double c00 = cost_of(pair, false, false), c01 = cost_of(pair, false, true),
                   c10 = cost_of(pair, true, false), c11 = cost_of(pair, true, true);
      add_gain(flow, a, c10 - c00);
      add_gain(flow, b, c11 - c10);
      flow.add_edge(a, b, std::max(0.0, c01 + c10 - c00 - c11), 0);
    } else if (a >= 0) {
      const bool takes = b == kTaken;
      add_gain(flow, a, cost_of(pair, true, takes) - cost_of(pair, false, takes));
    } else if (b >= 0) {
      const bool takes = a == kTaken;
      add_gain(flow, b, cost_of(pair, takes, true) - cost_of(pair, takes, false));
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

}  // namespace ohb
