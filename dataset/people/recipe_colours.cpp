#include "dataset/people/recipe_colours.h"

#include "dataset/model/colour.h"

namespace ohb::people {
namespace {

Vec3f from_srgb8(float r, float g, float b) {
  return {srgb_to_linear(r / 255), srgb_to_linear(g / 255), srgb_to_linear(b / 255)};
}

Vec3f mix(Vec3f a, Vec3f b, float share) {
  return (1 - share) * a + share * b;
}

}  // namespace

Vec3f skin_tone(float lightness, float warmth) {
  // sRGB of skin from deep to pale, about evenly spaced by eye.
  const Vec3f tones[] = {from_srgb8(62, 40, 32),   from_srgb8(92, 61, 47),    from_srgb8(128, 87, 66),
                         from_srgb8(168, 122, 96), from_srgb8(198, 154, 127), from_srgb8(217, 176, 150),
                         from_srgb8(230, 196, 174)};
  constexpr int kLast = 6;
  const float place = std::clamp(lightness, 0.0f, 1.0f) * kLast;
  const int below = std::min(static_cast<int>(place), kLast - 1);
  const Vec3f tone = mix(tones[below], tones[below + 1], place - static_cast<float>(below));
  return tone * Vec3f{1 - .03f * warmth, 1, 1 - .08f * warmth};
}

Vec3f hair_colour(int group, int years, Random& random) {
  const Vec3f black = from_srgb8(22, 19, 18), dark = from_srgb8(44, 31, 24), brown = from_srgb8(76, 52, 36),
              light = from_srgb8(120, 86, 56), blond = from_srgb8(176, 140, 92),
              red = from_srgb8(132, 62, 32), grey = from_srgb8(132, 128, 124);
  constexpr int kWhite = 4;
  const float place = random.unit();
  Vec3f colour = mix(black, dark, random.unit());
  if (group == kWhite)
    colour = place < .2f    ? colour
             : place < .5f  ? mix(brown, dark, random.unit())
             : place < .7f  ? mix(light, brown, random.unit())
             : place < .92f ? mix(blond, light, random.unit())
                            : red;
  else if (place < .3f)
    colour = mix(dark, brown, random.unit());
  else if (place > .93f)
    colour = mix(light, blond, random.unit());  // dyed
  const float greying = years > 38 ? static_cast<float>(years - 38) / 12 : 0;
  return random.chance(.6f) ? mix(colour, grey, .7f * greying * random.unit()) : colour;
}

Vec3f from_hsv(float hue, float saturation, float value) {
  const float place = 6 * (hue - std::floor(hue));
  const auto channel = [&](float offset) {
    float k = place + offset;
    if (k >= 6) k -= 6;
    const float ramp = std::clamp(std::min(k, 4 - k), 0.0f, 1.0f);
    return srgb_to_linear(value - value * saturation * ramp);
  };
  return {channel(5), channel(3), channel(1)};
}

Vec3f cloth_colour(Random& random) {
  const float place = random.unit();
  if (place < .12f) return from_hsv(random.unit(), .1f, random.within(.09f, .18f));
  if (place < .24f) return from_hsv(random.unit(), random.within(0, .06f), random.within(.85f, .95f));
  if (place < .34f) return from_hsv(random.unit(), .05f, random.within(.3f, .7f));
  if (place < .44f)
    return from_hsv(random.within(.58f, .66f), random.within(.5f, .8f), random.within(.2f, .45f));
  if (place < .54f)
    return from_hsv(random.within(.06f, .13f), random.within(.2f, .5f), random.within(.5f, .85f));
  return from_hsv(random.unit(), random.within(.3f, .9f), random.within(.3f, .9f));
}

Vec3f leather_colour(Random& random) {
  const float place = random.unit();
  if (place < .28f) return from_hsv(random.unit(), .08f, random.within(.1f, .17f));
  if (place < .36f)
    return from_hsv(random.within(.05f, .15f), random.within(0, .08f), random.within(.82f, .94f));
  if (place < .60f)
    return from_hsv(random.within(.03f, .09f), random.within(.4f, .8f), random.within(.22f, .6f));
  if (place < .75f)
    return from_hsv(random.within(-.03f, .02f), random.within(.6f, .9f), random.within(.3f, .65f));
  return from_hsv(random.unit(), random.within(.3f, .8f), random.within(.25f, .8f));
}

}  // namespace ohb::people
