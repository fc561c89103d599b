// Colours of skin, hair, cloth and leather, linear Rec. 709.
#pragma once

#include "dataset/model/vec.h"
#include "dataset/people/random.h"

namespace ohb::people {

/// From 0 (deep) to 1 (pale); `warmth` from -1 (rosy) to 1 (golden).
Vec3f skin_tone(float lightness, float warmth);

/// Natural colours by group (kGroupNames) and age, and now and then a dyed one.
Vec3f hair_colour(int group, int years, Random& random);

/// Hue, saturation and value in sRGB to linear. Hue in turns.
Vec3f from_hsv(float hue, float saturation, float value);

/// Any hue, and as often black, white, grey, navy and beige as people wear them.
Vec3f cloth_colour(Random& random);

/// Black, white, browns, reds and every other hue.
Vec3f leather_colour(Random& random);

}  // namespace ohb::people
