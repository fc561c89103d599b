// The six material maps as tensors, in the encodings of the learner.
#pragma once

#include "learner/torch.h"

namespace ohb::learner {

/// Batches of maps, each (B, C, H, W), float32 (or float64 in tests), contiguous. Values where the mask is 0
/// mean nothing.
struct MaterialMaps {
  torch::Tensor normal;        // C = 3, camera space, +X right, +Y up, +Z to the viewer; signed
  torch::Tensor diffuse;       // C = 3, linear Rec. 709
  torch::Tensor roughness;     // C = 1, perceptual
  torch::Tensor specular;      // C = 1, S: F0 = srgb_to_linear(S)
  torch::Tensor sss;           // C = 1, Principled subsurface weight
  torch::Tensor displacement;  // C = 1, in halves of the frame's width, positive to the viewer
};

}  // namespace ohb::learner
