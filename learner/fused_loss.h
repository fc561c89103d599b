// The multi-illumination rendering loss (paper, section on losses): truth and prediction lit by 37 point
// lights, L1 over the foreground. One fused loop gives the value and the analytic gradient; `oracle.h` holds
// the plain tensor twin that tests compare it with.
#pragma once

#include <cstdint>
#include <vector>

#include "learner/fused_kernel.h"
#include "learner/maps.h"

namespace ohb::learner {

/// 36 fixed lights of intensity 5.5, 2 away from the origin, at 5, 15, ..., 175 degrees in the XOZ and YOZ
/// planes (all on the viewer's side), and one at a place on the positive hemisphere of the same radius with
/// an intensity of 3 to 8, both a function of `random_key` alone.
std::vector<shading::Light<double>> training_lights(uint64_t random_key);

/// The fixed point light of the evaluation ("Point"): intensity 5.5 at (0, 0, 2), in front of the subject.
shading::Light<double> evaluation_light();

/// Mean over the foreground (mask > 0.5), the lights and 3 channels of |ln(1 + prediction) - ln(1 + truth)|
/// (or of the plain difference, see shading::Options), as a scalar that autograd knows: gradients go to the
/// maps of `prediction` that require them; backward may run once. 0 if there is no foreground. mask is (B, 1,
/// H, W). Runs on the CPU, on at::get_num_threads() threads; bit-identical for any number of them. Throws
/// std::invalid_argument for shapes or types that do not fit together.
torch::Tensor fused_rendering_loss(const MaterialMaps& prediction, const MaterialMaps& truth,
                                   const torch::Tensor& mask,
                                   const std::vector<shading::Light<double>>& lights,
                                   const shading::Options& options = {});

}  // namespace ohb::learner
