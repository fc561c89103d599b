// How likely a random walk over the faces ends in each class: the harmonic field of strokes and of start
// labels (Grady, "Multilabel random walker image segmentation using prior models", CVPR 2005).
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "dataset/labelling/alpha_expansion.h"

namespace ohb {

/// A stroke's hold on one face.
struct Seed {
  uint32_t face;
  uint8_t material_class;
  float conductance;  // of the walk from the face to the stroke's class
};

class RandomWalker {
 public:
  /// `conductance` of each pair is >= 0. `restart` of each node is > 0: the conductance to its start classes,
  /// so that there is one solution and a walk does not go far.
  RandomWalker(size_t nodes, const std::vector<EnergyPair>& conductance, std::vector<float> restart);
  ~RandomWalker();

  /// Solves (L + R + S) x_c = R start_c + S [class = c] for all classes; L is the graph's Laplacian. Each
  /// node's values sum to 1 and lie in [0,1]. Conjugate gradients with Jacobi's preconditioner from `guess`
  /// (empty: from `start`), until no Jacobi step would change a value by more than 1e-4: restarts keep the
  /// matrix so well conditioned that it pays (100k faces: 0.2 to 0.3 s of processor time for each new set of
  /// strokes; 0.8 s with a sparse factorisation as preconditioner).
  std::vector<ClassValues> solve(const std::vector<ClassValues>& start, const std::vector<Seed>& seeds,
                                 const std::vector<ClassValues>& guess = {}) const;

 private:
  struct Matrices;
  std::unique_ptr<Matrices> matrices_;
};

}  // namespace ohb
