// Group norm followed by SiLU, and its gradient, on plain memory (no libtorch): pictures whose channels lie
// side by side (B, H, W, C). libtorch's group norm is several times slower in this layout, which
// convolutions of few channels need.
#pragma once

#include "learner/parallel_for.h"

namespace ohb::learner::norm_silu_kernel {

/// Sizes; channels are divided evenly among the groups.
struct Shape {
  int64_t images = 0, pixels = 0, channels = 0, groups = 0;
};

/// What `forward` reads and writes.
struct Forward {
  const float* x;                   // images * pixels * channels
  const float *gain, *offset;       // per channel
  double epsilon;                   // added to the variance
  float* y;                         // as x
  float *mean, *inverse_deviation;  // images * groups, for backward
};
/// y = z sigmoid(z), z = (x - mean) / sqrt(variance + epsilon) * gain + offset, with mean and variance of
/// each image's group (Wu and He 2018, eq. 1 to 3).
/// The same bits whatever the threads: sums are taken over fixed runs of pixels and added in their order.
void forward(const Shape& shape, const Forward& planes, ParallelFor parallel_for);

/// What `backward` reads and writes.
struct Backward {
  const float *x, *y_gradient;             // as in forward
  const float *gain, *offset;              // per channel
  const float *mean, *inverse_deviation;   // from forward
  float* x_gradient;                       // images * pixels * channels
  float *gain_gradient, *offset_gradient;  // per channel
};
void backward(const Shape& shape, const Backward& planes, ParallelFor parallel_for);

}  // namespace ohb::learner::norm_silu_kernel
