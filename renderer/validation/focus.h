// Small or noisy regions need many more paths than the rest of the picture: they are rendered again, alone.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "renderer/render.h"
#include "renderer/validation/statistics.h"

namespace ohb::validation {

/// Boxes that hold every pixel with weight > 0, apart from each other: the bounding boxes of connected groups
/// of cells of 8 x 8 px, joined where they overlap.
std::vector<renderer::PixelBox> boxes_around(const std::vector<float>& weights, int width_px, int height_px);

/// Paths a pixel of each side's images, of which each has `seeds`.
struct SidesWork {
  int seeds = 0, our_spp = 0, cycles_spp = 0;
};

/// The work that makes the half-width of a ratio's interval (of ours to Cycles') `target` in the least time,
/// from the interval that `first` gave: each side's paths go as the root of its noise over the time of a
/// path. At most `most` times each side's paths, and at most max_spp in one image of Cycles. None if the
/// interval is that narrow already.
std::optional<SidesWork> more_work(const Interval& ratio, const SidesWork& first, double target, double most,
                                   int max_spp);

}  // namespace ohb::validation
