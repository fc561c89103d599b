// Labels of least energy: node costs and weighted distances between the labels of neighbours, by expansion
// moves (Boykov, Veksler and Zabih, "Fast approximate energy minimization via graph cuts", PAMI 2001; graph
// of each move after Kolmogorov and Zabih, PAMI 2004).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "dataset/model/regions.h"

namespace ohb::labelling {

/// One number a class.
using ClassValues = std::array<float, kClassCount>;

struct EnergyPair {
  uint32_t a, b;
  float weight;  // >= 0; 0 where labels do not matter
};

/// energy(labels) = sum of cost[n][label(n)] + sum of weight x distance[label(a)][label(b)].
struct LabelEnergy {
  std::vector<ClassValues> cost;
  std::vector<EnergyPair> pairs;
  /// A metric: 0 on the diagonal, symmetric, and no way round is shorter (else moves are not cuts).
  std::array<std::array<float, kClassCount>, kClassCount> distance;
};

double energy_of(const LabelEnergy& energy, const std::vector<uint8_t>& labels);

/// The best labels in which each node keeps its own or takes `label`: a minimum cut. Gives false, and leaves
/// the labels, if that is no better.
bool expand(const LabelEnergy& energy, uint8_t label, std::vector<uint8_t>& labels);

/// Expansions of all labels in turn, from `first` on, until none is better. The energy is then within twice
/// the largest ratio of distances of the least one; in practice within per mille.
void minimise(const LabelEnergy& energy, std::vector<uint8_t>& labels, uint8_t first = 0);

}  // namespace ohb::labelling
