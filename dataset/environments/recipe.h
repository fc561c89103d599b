// The recipes of synthetic environments: drawn by seed and index, painted at any size.
#pragma once

#include <cstdint>
#include <string>

#include "dataset/model/image.h"

namespace ohb::environments {

/// Changes when the same seed gives another map.
constexpr int kSynthesisVersion = 1;

/// Every ten lights have one clear sky, one with clouds, one sunset, one overcast, two studios, two of
/// coloured lamps, two rooms.
std::string category_of(uint64_t index);

struct SynthesisedLight {
  Image radiance;  // linear Rec. 709, its mean luminance between 0.35 and 1.2
  std::string category, words;
};

/// The environment of that seed and index, whatever the count and the threads; width / 2 rows.
SynthesisedLight synthesised(uint64_t seed, uint64_t index, int width_px);

}  // namespace ohb::environments
