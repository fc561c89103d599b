// How likely a random walk over the faces ends in each class: the harmonic field of strokes and of start
// labels (Grady, "Multilabel random walker image segmentation using prior models", CVPR 2005).
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "dataset/labelling/alpha_expansion.h"

namespace ohb::labelling {

/// A stroke's hold on one face.
struct Seed {
  uint32_t face;
  uint8_t material_class;
  float conductance;  // of the walk from the face to the stroke's class
};

class RandomWalker {
 public:
  /// `conductance` of each pair is >= 0. `restart` of each node is > 0 (1e-4 of all its pairs is the least
  /// that counts): the conductance to its start classes, so that there is one solution and a walk is short.
  RandomWalker(size_t nodes, const std::vector<EnergyPair>& conductance, std::vector<float> restart);
  ~RandomWalker();

  /// Solves (L + R + S) x_c = R start_c + S [class = c] for all classes; L is the graph's Laplacian. Each
  /// node's values sum to 1 and lie in [0,1]. Conjugate gradients from `guess` (empty: from `start`) until no
  /// preconditioned step would change a value by more than 2e-4 (measured: within 5e-3 of the solution, 2e-5
  /// in the mean). The preconditioner is Jacobi's plus the exact solution summed over groups of nodes that
  /// hang together most (100k faces: 75 ms of processor time for each new set of strokes; Jacobi's alone 80
  /// to 350, a sparse factorisation 800). The same bits for any number of threads.
  std::vector<ClassValues> solve(const std::vector<ClassValues>& start, const std::vector<Seed>& seeds,
                                 const std::vector<ClassValues>& guess = {}) const;

  struct Matrices;

 private:
  std::unique_ptr<Matrices> matrices_;
};

}  // namespace ohb::labelling
