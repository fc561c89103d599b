// The two solvers of labelling against what is obviously right: all labels tried, and a dense solve.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

#include "dataset/labelling/alpha_expansion.h"
#include "dataset/labelling/random_walker.h"

namespace ohb {
using namespace labelling;
namespace {

/// A random graph of `nodes` with costs and weights in [0, 1) x scale and a metric.
LabelEnergy random_energy(int nodes, float pair_scale, std::mt19937& random) {
  std::uniform_real_distribution<float> share(0, 1);
  LabelEnergy energy;
  for (int n = 0; n < nodes; ++n)
    energy.cost.push_back({share(random), share(random), share(random), share(random)});
  for (uint32_t a = 0; a < static_cast<uint32_t>(nodes); ++a)
    for (uint32_t b = a + 1; b < static_cast<uint32_t>(nodes); ++b)
      if (share(random) < 0.4f) energy.pairs.push_back({a, b, pair_scale * share(random)});
  // Any distances within a factor of two of each other are a metric.
  for (int i = 0; i < kClassCount; ++i)
    for (int j = 0; j < i; ++j) energy.distance[i][j] = energy.distance[j][i] = 1 + share(random);
  for (int i = 0; i < kClassCount; ++i) energy.distance[i][i] = 0;
  return energy;
}

TEST(LabelSolver, AnExpansionIsTheBestOfAllMoves) {
  std::mt19937 random(1);
  constexpr int kNodes = 9;
  for (int trial = 0; trial < 60; ++trial) {
    const LabelEnergy energy = random_energy(kNodes, trial % 3 == 0 ? 0.05f : 0.6f, random);
    std::vector<uint8_t> labels;
    for (int n = 0; n < kNodes; ++n) labels.push_back(static_cast<uint8_t>(random() % kClassCount));
    const uint8_t label = static_cast<uint8_t>(trial % kClassCount);
    double least = energy_of(energy, labels);
    for (unsigned move = 0; move < 1u << kNodes; ++move) {
      std::vector<uint8_t> moved = labels;
      for (int n = 0; n < kNodes; ++n)
        if (move >> n & 1) moved[n] = label;
      least = std::min(least, energy_of(energy, moved));
    }
    expand(energy, label, labels);
    ASSERT_NEAR(energy_of(energy, labels), least, 1e-6) << trial;
  }
}

TEST(LabelSolver, TheResultIsNearTheLeastOfAllLabels) {
  std::mt19937 random(2);
  constexpr int kNodes = 7;
  double sum = 0, least_sum = 0;
  for (int trial = 0; trial < 30; ++trial) {
    const LabelEnergy energy = random_energy(kNodes, 0.5f, random);
    std::vector<uint8_t> labels(kNodes, static_cast<uint8_t>(trial % kClassCount));
    minimise(energy, labels, static_cast<uint8_t>(trial % kClassCount));
    double least = 1e30;
    std::vector<uint8_t> all(kNodes);
    for (unsigned code = 0; code < 1u << (2 * kNodes); ++code) {
      for (int n = 0; n < kNodes; ++n) all[n] = code >> (2 * n) & 3;
      least = std::min(least, energy_of(energy, all));
    }
    EXPECT_LE(energy_of(energy, labels), 2 * 2 * least);  // the theorem's bound
    sum += energy_of(energy, labels);
    least_sum += least;
  }
  EXPECT_LT(sum, 1.01 * least_sum);
}

TEST(LabelSolver, NodesWithoutPairsTakeTheirCheapestLabel) {
  LabelEnergy energy;
  energy.cost = {{3, 1, 2, 4}, {1, 3, 2, 4}, {3, 4, 2, 1}};
  energy.distance = {};
  std::vector<uint8_t> labels(3, kFabric);
  minimise(energy, labels);
  EXPECT_EQ(labels, (std::vector<uint8_t>{kHair, kSkin, kLeather}));
}

struct WalkProblem {
  std::vector<EnergyPair> pairs;
  std::vector<float> restart;
  std::vector<ClassValues> start;
  std::vector<Seed> seeds;
};

WalkProblem random_walk(uint32_t nodes, std::mt19937& random) {
  std::uniform_real_distribution<float> share(0, 1);
  WalkProblem walk;
  for (uint32_t n = 0; n < nodes; ++n) {
    walk.restart.push_back(0.001f + 0.1f * share(random));
    ClassValues p = {share(random), share(random), share(random), share(random)};
    const float sum = p[0] + p[1] + p[2] + p[3];
    for (float& v : p) v /= sum;
    walk.start.push_back(p);
    if (n > 0) walk.pairs.push_back({static_cast<uint32_t>(random() % n), n, 0.02f + share(random)});
    if (n > 5) walk.pairs.push_back({n - 5, n, share(random)});
  }
  for (uint32_t n = 0; n < nodes; n += 17) walk.seeds.push_back({n, static_cast<uint8_t>(random() % 4), 50});
  return walk;
}

TEST(LabelSolver, TheWalkIsThatOfADenseSolve) {
  std::mt19937 random(3);
  const uint32_t nodes = 120;
  const WalkProblem walk = random_walk(nodes, random);
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(nodes, nodes),
                  right = Eigen::MatrixXd::Zero(nodes, kClassCount);
  for (const EnergyPair& pair : walk.pairs) {
    matrix(pair.a, pair.a) += pair.weight;
    matrix(pair.b, pair.b) += pair.weight;
    matrix(pair.a, pair.b) -= pair.weight;
    matrix(pair.b, pair.a) -= pair.weight;
  }
  for (uint32_t n = 0; n < nodes; ++n) {
    matrix(n, n) += walk.restart[n];
    for (int c = 0; c < kClassCount; ++c) right(n, c) += walk.restart[n] * walk.start[n][c];
  }
  for (const Seed& seed : walk.seeds) {
    matrix(seed.face, seed.face) += seed.conductance;
    right(seed.face, seed.material_class) += seed.conductance;
  }
  const Eigen::MatrixXd dense = matrix.fullPivLu().solve(right);
  const RandomWalker walker(nodes, walk.pairs, walk.restart);
  const auto cold = walker.solve(walk.start, walk.seeds);
  const auto warm = walker.solve(walk.start, walk.seeds, walker.solve(walk.start, {}));
  for (uint32_t n = 0; n < nodes; ++n)
    for (int c = 0; c < kClassCount; ++c) {
      EXPECT_NEAR(cold[n][c], dense(n, c), 1e-3) << n;
      EXPECT_NEAR(warm[n][c], dense(n, c), 1e-3) << n;
    }
}

TEST(LabelSolver, AWalkStaysAProbability) {
  std::mt19937 random(4);
  const WalkProblem walk = random_walk(300, random);
  for (const ClassValues& p : RandomWalker(300, walk.pairs, walk.restart).solve(walk.start, walk.seeds)) {
    float sum = 0;
    for (float v : p) {
      EXPECT_GE(v, 0);
      sum += v;
    }
    EXPECT_NEAR(sum, 1, 1e-6f);
  }
}

/// Faces without area that touch no others: rounding errors there turned a whole person to noise.
TEST(LabelSolver, WhatNothingHoldsUpsetsNothingElse) {
  constexpr uint32_t kChain = 400, kLoose = 16;
  std::mt19937 random(3);
  std::uniform_real_distribution<float> share(0, 1);
  std::vector<EnergyPair> pairs;
  for (uint32_t n = 1; n < kChain; ++n) pairs.push_back({n - 1, n, 4 * share(random)});
  std::vector<float> restart(kChain, 0.05f);
  const RandomWalker alone(kChain, pairs, restart);
  for (uint32_t n = kChain + 1; n < kChain + kLoose; ++n) pairs.push_back({n - 1, n, 100});
  restart.resize(kChain + kLoose, 1e-8f);
  const RandomWalker walker(kChain + kLoose, pairs, restart);
  const auto starts = [&] {
    std::vector<ClassValues> start(kChain + kLoose);
    for (ClassValues& p : start) {
      const float skin = share(random), hair = share(random) * (1 - skin);
      p = {skin, hair, 1 - skin - hair, 0};
    }
    return start;
  };
  std::vector<ClassValues> guess, guess_alone;
  for (int call = 0; call < 3; ++call) {
    const std::vector<ClassValues> start = starts();
    guess = walker.solve(start, {}, guess);
    guess_alone = alone.solve({start.begin(), start.begin() + kChain}, {}, guess_alone);
    for (uint32_t n = 0; n < kChain; ++n)
      for (int c = 0; c < kClassCount; ++c) ASSERT_NEAR(guess[n][c], guess_alone[n][c], 0.01) << call;
  }
}

}  // namespace
}  // namespace ohb
