// The difference between two ways to render, told apart from the noise of both.
#pragma once

#include <vector>

#include "renderer/rounds.h"

namespace ohb::renderer {

/// Values of some pixels of K independent images: [image][light][3 x pixel + channel].
using PilotStack = std::vector<std::vector<std::vector<float>>>;

/// About `count` of the seen pixels of a view, spread evenly: every pixel of a coarser grid.
std::vector<size_t> pilot_pixels(const Picture& picture, size_t count);

/// K images of `spp` paths at those pixels. Stacks of equal seeds use the same random numbers.
PilotStack render_pilot_stack(const Picture& picture, const std::vector<size_t>& pixels, int images, int spp,
                              RenderStatistics& statistics, const PixelsDone& done);

/// Square of the relative difference of expectations and its two-sided confidence interval.
struct SquaredDifference {
  double value = 0, low = 0, high = 0;
};

/// sum |E[b - a]|^2 / sum |E[a]|^2 over the values of light `light_a` of one stack and `light_b` of another
/// (or the same). Both sums by products of different images: an unbiased U statistic each. Interval: what
/// leaving out each image, and each sixteenth of the pixels, changes (jackknife; for such products it errs on
/// the wide side, Efron and Stein 1981), and Student's t with two-sided probability `alpha`.
SquaredDifference squared_difference(const PilotStack& a, size_t light_a, const PilotStack& b, size_t light_b,
                                     double alpha);

}  // namespace ohb::renderer
