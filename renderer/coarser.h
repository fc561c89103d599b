// Maps of half the resolution, for scenes that need no more.
#pragma once

#include "dataset/model/environment.h"
#include "dataset/model/model.h"

namespace ohb::renderer {

/// Each texel the mean of 2 x 2; needs an even width and height.
Image halved(const Image& image);

/// `halvings` times, rows weighted by their solid angle so that the power stays; no further than to 64 texels
/// of width or an odd size.
Environment coarser_environment(const Environment& environment, int halvings);

/// The model with maps of `size_px` at most, by halving, for radiance alone (no displacement maps); sets stay
/// where a size is odd.
Model with_coarser_maps(const Model& model, int size_px);

/// The largest width of the model's maps.
int largest_map_px(const Model& model);

}  // namespace ohb::renderer
