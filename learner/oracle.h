// The shader in plain tensor operations: for evaluation, and for the rendering loss on devices other than the
// CPU (chunked_loss.h). With it the rendering loss by autograd: slow (gigabytes at 512 x 512), obviously
// right, kept as the twin that tests and benchmarks compare the other two with.
#pragma once

#include <vector>

#include "learner/fused_kernel.h"
#include "learner/maps.h"

namespace ohb::learner {

/// Radiance towards the viewer, linear, (B, L, 3, H, W): every pixel by every light, background included
/// (whatever the maps hold there).
torch::Tensor render_maps(const MaterialMaps& maps, const std::vector<shading::Light<double>>& lights,
                          const shading::Options& options = {});

/// Where pixels are in the shader's frame (shading.h); broadcast to the maps' (B, 1, H, W).
struct PixelPlaces {
  torch::Tensor u, v;
};
/// Of the pixels of those columns and rows, from 0 (tensors of floats), of a picture of width x height.
PixelPlaces places_of(const torch::Tensor& columns, const torch::Tensor& rows, int64_t width_px,
                      int64_t height_px);

/// The same as render_maps for pixels that need not be a whole picture: a list of N of them is (1, C, 1, N).
torch::Tensor render_pixels(const MaterialMaps& maps, const PixelPlaces& places,
                            const std::vector<shading::Light<double>>& lights,
                            const shading::Options& options = {});

/// What the rendering loss is the mean of: |ln(1 + mine) - ln(1 + wanted)| or, where it is linear, |mine -
/// wanted|.
torch::Tensor radiance_difference(const torch::Tensor& mine, const torch::Tensor& wanted,
                                  const shading::Options& options);

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
