// Maps at the size of a picture from those that networks gave at their own, smaller size.
#pragma once

#include "learner/torch.h"

namespace ohb::learner {

/// A network's input (B, 4, H, W) (see network_input) at size_px x size_px: colours averaged in linear light,
/// weighted by the mask.
torch::Tensor averaged_input(const torch::Tensor& input, int64_t size_px);

/// The ten channels (B, 10, h, w) that networks gave for `small` (B, 4, h, w), at the size of `input`
/// (B, 4, H, W), of which `small` is the averaged_input; in [0, 1]. All is weighted by the mask.
///
/// Normals and displacement are interpolated: what the picture shows is colour, and colour is no relief.
/// Albedo, roughness, specular and sss follow the picture by the fast guided filter with a guide in colour
/// (He and Sun 2015, "Fast Guided Filter", algorithm 2; He, Sun and Tang 2013, equations 14 to 19): within
/// windows of the small picture they are linear functions of its sRGB values, fitted with a small ridge, and
/// these functions are applied to the large picture.
torch::Tensor output_at_size_of(const torch::Tensor& input, const torch::Tensor& output,
                                const torch::Tensor& small);

}  // namespace ohb::learner
