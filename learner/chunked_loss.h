// The rendering loss on any device, by plain tensor operations: the shader of oracle.h and autograd over a
// few pixels at a time, so that it fits beside the network on a GPU.
#pragma once

#include <cstdint>
#include <vector>

#include "learner/fused_kernel.h"
#include "learner/maps.h"

namespace ohb::learner {

/// Memory for what is in between while one chunk of pixels is reflected, and differentiated, under all
/// lights.
constexpr int64_t kChunkBytes = int64_t{512} << 20;
/// The numbers that shader and autograd hold at once for a pixel under a light: the tests measured 83, and
/// allocators waste some. With 37 lights and float32, 512 MB are 512 x 2^20 / (37 x 120 x 4) = 30229 pixels,
/// half of 256 x 256; a pixel alone takes 18 kB, so that lights need no chunks.
constexpr int64_t kNumbersPerLitPixel = 120;

/// Value and gradients of fused_rendering_loss, up to rounding, of maps and mask on one device of any kind.
/// Beyond the maps' gradients and 24 bytes a pixel of foreground it takes `chunk_bytes`, and at least what
/// one pixel needs, whatever the picture, the batch and the number of lights. The forward pass makes the
/// gradients chunk by chunk; backward may run once. Throws std::invalid_argument for shapes, types or devices
/// that do not fit together.
torch::Tensor chunked_rendering_loss(const MaterialMaps& prediction, const MaterialMaps& truth,
                                     const torch::Tensor& mask,
                                     const std::vector<shading::Light<double>>& lights,
                                     const shading::Options& options = {}, int64_t chunk_bytes = kChunkBytes);

}  // namespace ohb::learner
