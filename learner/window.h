// Square windows of a sample, averaged to the size that a network sees.
#pragma once

#include <cstdint>

#include "dataset/model/image.h"

namespace ohb::learner {

struct Window {
  int left_px = 0, top_px = 0, side_px = 0;
};

/// The window of `image` as size_px x size_px averages over its pixels, those at the edges of an average by
/// the part of them that lies in it; weighted by `weight` (one channel, as large as `image`) unless it is
/// null, and 0 where nothing weighs. The window lies within the image and is no smaller than size_px.
Image averaged(const Image& image, const Image* weight, const Window& window, int size_px);

/// A part of a person, as photographs show: in half of the cases (a function of `key`) a window from size_px
/// to the whole width, its logarithm uniform, anywhere in the frame where a tenth of it is foreground;
/// else, and where none is found, all of the mask. The mask is square.
Window drawn_window(const Image& mask, int size_px, uint64_t key);

}  // namespace ohb::learner
