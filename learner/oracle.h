// The rendering loss in plain tensor operations and autograd: slow (gigabytes at 512 x 512), obviously
// right, kept as the twin that tests and benchmarks compare the fused loss with. Also the shader for few
// lights, for evaluation.
#pragma once

#include <vector>

#include "learner/fused_kernel.h"
#include "learner/maps.h"

namespace ohb::learner {

/// Radiance towards the viewer, linear, (B, L, 3, H, W): every pixel by every light, background included
/// (whatever the maps hold there).
torch::Tensor render_maps(const MaterialMaps& maps, const std::vector<shading::Light<double>>& lights,
                          const shading::Options& options = {});

/// The same value as fused_rendering_loss, by autograd.
torch::Tensor oracle_rendering_loss(const MaterialMaps& prediction, const MaterialMaps& truth,
                                    const torch::Tensor& mask,
                                    const std::vector<shading::Light<double>>& lights,
                                    const shading::Options& options = {});

/// Normals of unit length: v / |v| over dimension 1; (0, 0, 1) where |v| < 1e-4.
torch::Tensor unit_normals(const torch::Tensor& v);

/// Linear F0 of the map values S.
torch::Tensor f0_map(const torch::Tensor& specular, shading::SpecularEncoding encoding);

}  // namespace ohb::learner
