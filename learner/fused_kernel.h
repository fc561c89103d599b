// The rendering loss and its gradient over a list of pixels, on plain memory (no libtorch). Truth and
// prediction are reflected in the same loop and nothing is stored: blocks of pixels times all lights.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "learner/shading.h"

namespace ohb::learner::shading {

/// How the map value S gives the linear reflectance at normal incidence F0.
enum class SpecularEncoding {
  kSrgbF0,    // F0 = srgb_to_linear(S): the convention of our samples
  kDisney08,  // F0 = 0.08 S: Blender's "Specular" socket
  kLinearF0   // F0 = S
};

struct Options {
  SpecularEncoding specular = SpecularEncoding::kSrgbF0;
  /// L1 of ln(1 + radiance) if true, of radiance ("as in the paper") if false. In linear L1 at the geometry
  /// prior's roughness of 0.2, one pixel in a hundred owns the gradient.
  bool log_domain = true;
  /// Roughness below is raised to this, with gradient 0 there. The data have 0.25 to 0.85.
  double min_roughness = 0.15;
};

/// Linear F0 of a map value, and its slope dF0/dS. Values outside [0,1] are clamped with slope 0.
struct F0 {
  double value, slope;
};
F0 f0_of(double specular, SpecularEncoding encoding);

/// Planes of one image, by Plane. kNormal and kDiffuse point to 3 planes, each `plane` values after the
/// other; the others to one. The normal may have any length: it is normalised here ((0, 0, 1) with gradient 0
/// below 1e-4). displacement is in halves of the frame's width. Gradient planes may be null: then not wanted.
template <typename Pointer>
using Planes = std::array<Pointer, kPlaneCount>;

template <typename T>
struct Job {
  int width_px = 0, height_px = 0;
  Planes<const T*> truth, prediction;
  Planes<T*> gradient;  // of `scale` times the summed loss; written (not added to) at the listed pixels
  std::vector<Light<T>> lights;
  Options options;
  double scale = 1;
};

/// Pixels that are reflected together.
constexpr int kBlock = 128;

/// Sum over the pixels (indices y * width + x), the lights and 3 channels of the loss, times job.scale; fills
/// job.gradient. On `threads` threads, with the same bits for any number of them.
template <typename T>
double loss_of_pixels(const Job<T>& job, const std::vector<int32_t>& pixels, int threads);

}  // namespace ohb::learner::shading
