// One update of AdamW on plain memory (no libtorch). By libtorch's operators it takes some twenty passes over
// arrays that are larger than the cache; this takes one.
#pragma once

#include <cstdint>

namespace ohb::learner::adamw_kernel {

/// The numbers of a step (Loshchilov and Hutter 2019, algorithm 2).
struct Step {
  float beta1, beta2, epsilon;
  float keep;            // what decay leaves of the parameter: 1 - learning rate x decay
  float rate;            // learning rate over 1 - beta1^t
  float second_scale;    // 1 over the root of 1 - beta2^t
  float average_weight;  // of the new parameter in its average
};

/// Arrays of `count` each; `average` may be null.
struct Arrays {
  const float* gradient;
  float *parameter, *first, *second, *average;
  int64_t count;
};

void update(const Step& step, const Arrays& arrays);

}  // namespace ohb::learner::adamw_kernel
