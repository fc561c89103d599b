// How large and how costly a network is.
#pragma once

#include <cstdint>
#include <functional>

#include "learner/torch.h"

namespace ohb::learner {

int64_t parameter_count(const torch::nn::Module& module);

/// Multiply-accumulates of the convolutions and matrix products that `forward` runs (without gradients), as
/// libtorch calls them; norms, activations and interpolation don't count.
int64_t count_multiplies(const std::function<void()>& forward);

/// The same of a network at size_px x size_px, from two small runs: convolutions cost a P and attention
/// b P^2 for P pixels, so that runs at 32 and 64 tell every size exactly. `forward` runs at the given size.
int64_t multiplies_at(const std::function<void(int64_t size_px)>& forward, int64_t size_px);

}  // namespace ohb::learner
