// What cameras, their software and matting do to a picture, for training: rendered pictures are cleaner than
// any photograph. Not in the paper.
#pragma once

#include <cstdint>

#include "learner/data.h"

namespace ohb::learner {

/// Changes `e.input` alone, in place, the maps stay: exposure (up to half a stop either way; what exceeds 1
/// clips), white balance (each channel up to 12 %), a tone curve, a slight blur, noise of up to 3 % of white,
/// and a matte that is a pixel too small, too large or too soft, each drawn anew.
/// A function of e and key; e is a batch of one.
void take_snapshot(Example& e, uint64_t key);

}  // namespace ohb::learner
