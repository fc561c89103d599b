// A scan's diffuse pictures, made worse.
#pragma once

#include "dataset/model/scan.h"

namespace ohb {

/// Adds normal noise of that standard deviation (of the encoded values in [0,1]) to each channel.
void add_noise(Scan& scan, double deviation);

/// Averages over squares of 2 radius_px + 1 pixels, background included, as a wrong atlas scale would.
void blur(Scan& scan, int radius_px);

}  // namespace ohb
