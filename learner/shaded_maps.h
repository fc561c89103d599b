// What the two implementations of the rendering loss (fused_loss.h, chunked_loss.h) share.
#pragma once

#include <array>

#include "learner/maps.h"
#include "learner/shading.h"

namespace ohb::learner {

/// A tensor for each map that the shader reads, by shading::Plane.
using ShadedMaps = std::array<torch::Tensor, shading::kPlaneCount>;

/// What the learner calls the maps that the shader reads, by shading::Plane.
constexpr std::array<const LearnedMap*, shading::kPlaneCount> shaded_maps() {
  std::array<const LearnedMap*, shading::kPlaneCount> maps{};
  for (size_t i = 0; i < maps.size(); ++i)
    for (const LearnedMap& map : kMaps)
      if (map.name == shading::kPlaneNames[i]) maps[i] = &map;
  return maps;
}
constexpr std::array<const LearnedMap*, shading::kPlaneCount> kShadedMaps = shaded_maps();

ShadedMaps shaded_maps_of(const MaterialMaps& maps);

/// Throws std::invalid_argument unless mask is (B, 1, H, W), each map (B, C, H, W) on the mask's device, and
/// all maps of one type.
void check_shaded_maps(const MaterialMaps& prediction, const MaterialMaps& truth, const torch::Tensor& mask);

/// `value` (a scalar tensor) as a function of `maps` whose gradients are known: those of its sum, undefined
/// where none is wanted. They are handed over in the backward pass, which may run once.
torch::Tensor with_gradients(const torch::Tensor& value, const ShadedMaps& maps, const ShadedMaps& gradients);

}  // namespace ohb::learner
