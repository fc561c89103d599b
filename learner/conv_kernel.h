// Convolutions and their gradients on plain memory (no libtorch), for processors with AVX2: pictures whose
// channels lie side by side (B, H, W, C). oneDNN's and OpenBLAS' take one and a half to four times as long in
// this layout where planes are large, strides are 2, or channels are few.
#pragma once

#include "learner/parallel_for.h"

namespace ohb::learner::conv_kernel {

/// Sizes; zeros lie around the picture.
struct Shape {
  int64_t images = 0, height = 0, width = 0, channels_in = 0, channels_out = 0;
  int64_t stride = 1;  // 1 or 2
  int64_t taps = 3;    // 3 for 3x3, 1 for 1x1 (of stride 1)
  int64_t height_out() const { return (height - 1) / stride + 1; }
  int64_t width_out() const { return (width - 1) / stride + 1; }
};
/// What channels_out, and for the gradient channels_in, must be a multiple of.
constexpr int64_t kBlock = 16;

/// Whether they were compiled, for processors with AVX2.
bool is_compiled();
/// Whether they pay on this processor: with AVX-512 libtorch's own are others, which were not measured.
bool pays();

/// y (B, H', W', out) = bias + sum over taps of x(p stride + tap, in) weight(out, in, tap), from x (B, H, W,
/// in), weight (out, in, taps, taps) and bias (out) or nullptr. The same bits whatever the threads. Throws
/// logic_error unless it is compiled.
void forward(const Shape& shape, const float* x, const float* weight, const float* bias, float* y,
             ParallelFor parallel_for);

/// gradient (out, in, 3, 3) = sum over images and places p of y_gradient(p, out) x(p stride + tap, in), from
/// x and y_gradient (B, H', W', out), taps 3. The same bits whatever the threads: sums are taken over
/// fixed runs of rows and added in their order. Throws as forward.
void weight_gradient(const Shape& shape, const float* x, const float* y_gradient, float* gradient,
                     ParallelFor parallel_for);

}  // namespace ohb::learner::conv_kernel
