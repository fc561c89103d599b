// How many paths each pixel gets.
#pragma once

#include <cstdint>
#include <vector>

#include "dataset/model/sample.h"

namespace ohb {

/// Paths of each pixel of a square image so that the sum is about mean_spp times the seen pixels and the mean
/// squared error is least: in proportion to the standard deviation of one path (Neyman 1934), which
/// independent pilot images of the same number of paths estimate, pooled over blocks of 4 x 4 pixels and
/// their eight neighbours. Several lights count by their relative variance. No seen pixel gets less than a
/// quarter of the mean: a pilot may have missed what is rare. `pilots` are [image][light]; `seen` as of
/// footprint().
std::vector<uint32_t> adaptive_budget(const std::vector<std::vector<SampleLight>>& pilots,
                                      const std::vector<uint8_t>& seen, int size_px, double mean_spp);

}  // namespace ohb
