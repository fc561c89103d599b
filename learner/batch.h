// What a training step sees: examples as they come from the loader, varied and joined.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "learner/loader.h"

namespace ohb::learner {

struct Batch {
  std::vector<std::string> names;  // of the examples, for messages
  torch::Tensor input, mask;       // (B, 4, H, W), (B, 1, H, W)
  MaterialMaps truth;              // (B, C, H, W)
};

/// The same on another device; itself where it is there already.
Batch moved_to(const torch::Device& device, Batch batch);

/// Keys of what is done to examples; 0: nothing.
struct Augmentation {
  uint64_t mirror_key = 0, recolour_key = 0, snapshot_key = 0;
};

/// Half of the examples are mirrored, another half recoloured, all taken by a camera: which ones and how is a
/// function of key and position.
void vary(Example& example, const Augmentation& augmentation, uint64_t position);

/// The loader's next `size` examples. Throws as Loader::next.
Batch next_batch(Loader& loader, int size);

}  // namespace ohb::learner
