// Small or noisy regions need many more paths than the rest of the picture: they are rendered again, alone.
#pragma once

#include <cstdint>
#include <vector>

#include "renderer/render.h"
#include "renderer/validation/statistics.h"

namespace ohb {

/// Boxes that hold every pixel with weight > 0, apart from each other: the bounding boxes of connected groups
/// of cells of 8 x 8 px, joined where they overlap.
std::vector<PixelBox> boxes_around(const std::vector<float>& weights, int width_px, int height_px);

/// How much more work (paths in all, or seeds x spp) makes the half-width of the interval `target`, at
/// least 1.
double work_factor(const Interval& interval, double target);

/// How to spread `factor` times spp x seeds over seeds of at most max_spp.
struct Work {
  int spp = 0, seeds = 0;
};
Work spread_work(double factor, int spp, int seeds, int max_spp);

}  // namespace ohb
