// Group norm followed by SiLU as one differentiable operation.
#pragma once

#include "learner/torch.h"

namespace ohb::learner {

/// SiLU(group norm(x)) of x (B, C, H, W), gain and offset (C), C a multiple of `groups`; differentiable once.
/// Pictures of floats on the CPU are taken channels last and come out so, by norm_silu_kernel.h; anything
/// else by libtorch's own operators. The sigmoid is 2e-7 from theirs.
torch::Tensor norm_silu(const torch::Tensor& x, int64_t groups, const torch::Tensor& gain,
                        const torch::Tensor& offset, double epsilon);

}  // namespace ohb::learner
