// One function a category: what is drawn, and how it is painted.
#pragma once

#include <string>

#include "dataset/model/image.h"
#include "dataset/model/sampling.h"
#include "dataset/model/vec.h"

namespace ohb::environments {

/// A map in any unit, and what it shows.
struct Painting {
  Image map;
  std::string words;
};

Painting clear_sky(Random& random, int width_px);
Painting cloudy_sky(Random& random, int width_px);
Painting sunset(Random& random, int width_px);
Painting overcast(Random& random, int width_px);
Painting studio(Random& random, int width_px);
Painting coloured_lamps(Random& random, int width_px);
Painting room_with_windows(Random& random, int width_px);

/// Uniform in [low, high).
inline float within(Random& random, float low, float high) {
  return low + (high - low) * random.next();
}
/// The same in ratios: as often between 1 and 2 as between 2 and 4.
inline float within_ratio(Random& random, float low, float high) {
  return low * std::pow(high / low, random.next());
}
/// 0 to count - 1.
inline int below(Random& random, int count) {
  return std::min(static_cast<int>(random.next() * static_cast<float>(count)), count - 1);
}

/// Light of a full hue (in turns: 0 red, 1/3 green, 2/3 blue) and saturation, of luminance 1.
Vec3f hue_of(float hue_turns, float saturation);
/// White light of a colour temperature, 2000 to 12000 K, of luminance 1: Kim et al.'s cubic fit of the
/// Planckian locus (US patent 7024034 B2), seen by an eye adapted to D65.
Vec3f light_of_temperature(float kelvin);

/// Sub-samples a texel along each side.
constexpr int kPaintSamples = 2;

}  // namespace ohb::environments
