// Convolutions as one differentiable operation each.
#pragma once

#include "learner/torch.h"

namespace ohb::learner {

/// `layer` (3x3, zeros around the picture, stride 1 or 2) of x (B, C, H, W); differentiable once. By
/// conv_kernel.h where that pays: pictures of floats on the CPU, channels multiples of 16.
torch::Tensor conv3x3(const torch::Tensor& x, const torch::nn::Conv2d& layer);

/// A 1x1 convolution: weight (out, in, 1, 1), bias (out) or undefined. By conv_kernel.h as above (`out` a
/// multiple of 16), else as a matrix product over pixels (channels last): libtorch 1.13 does it by one
/// product an image over planes, in the backward pass at a third of the speed.
torch::Tensor pointwise(const torch::Tensor& x, const torch::Tensor& weight, const torch::Tensor& bias);

/// While one lives, this thread's convolutions are libtorch's own, for who counts its operators.
class PlainConvolutions {
 public:
  PlainConvolutions();
  ~PlainConvolutions();
  PlainConvolutions(const PlainConvolutions&) = delete;
  PlainConvolutions& operator=(const PlainConvolutions&) = delete;

 private:
  bool before_;
};

}  // namespace ohb::learner
