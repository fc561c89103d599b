#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "dataset/environments/area_lights.h"
#include "dataset/environments/landscape.h"
#include "dataset/environments/recipe_kinds.h"
#include "dataset/model/noise.h"

namespace ohb::environments {
namespace {

float luminance(Vec3f rgb) {
  return 0.2126f * rgb.x + 0.7152f * rgb.y + 0.0722f * rgb.z;
}

/// A room without windows: walls, a lighter floor, and on both what the lamps throw about.
struct Backdrop {
  Vec3f wall, floor;  // radiance
  uint64_t pattern;
  Vec3f at(Vec3f way) const {
    const float mottled = 0.9f + 0.2f * fractal_noise(way * 1.5f, 3, pattern);
    const float is_floor = smooth(0.02f, -0.06f, way.y);
    return (wall * ((1 - is_floor) * (1 + 0.35f * way.y)) + floor * (is_floor * (1 + 0.6f * way.y))) *
           mottled;
  }
};

Vec3f with_lamps(const std::vector<AreaLight>& lamps, Vec3f way, Vec3f behind) {
  for (const AreaLight& lamp : lamps) {
    Vec3f radiance;
    if (shines(lamp, way, radiance)) return radiance;
    // The black frame of a softbox.
    AreaLight frame = lamp;
    frame.half_width += 0.012f, frame.half_height += lamp.shape == AreaLight::Shape::kRing ? -0.012f : 0.012f;
    if (shines(frame, way, radiance)) return behind * 0.15f;
  }
  return behind;
}

/// Braces around what is drawn keep the order of the draws, which arguments have not.
struct Lamp {
  AreaLight::Shape shape;
  Vec3f towards;
  float half_width, half_height;
  Vec3f colour;
  float power;  // the luminance that it adds at the subject, as radiance x sr
};

AreaLight lamp_of(const Lamp& drawn) {
  AreaLight lamp;
  lamp.shape = drawn.shape, lamp.towards = drawn.towards;
  lamp.half_width = drawn.half_width, lamp.half_height = drawn.half_height;
  lamp.radiance = drawn.colour * static_cast<float>(static_cast<double>(drawn.power) / solid_angle_of(lamp));
  return lamp;
}

AreaLight key_light(Random& random, float side, Vec3f colour, std::string& words) {
  const float azimuth = side * within(random, 15, 75), elevation = within(random, 10, 60);
  const Vec3f towards = towards_degrees({azimuth, elevation});
  const int shape = below(random, 4);
  AreaLight lamp;
  if (shape == 0) {
    const float radius = within(random, 0.15f, 0.4f);
    lamp = lamp_of({AreaLight::Shape::kDisc, towards, radius, 0, colour, 1});
    words = "round key";
  } else if (shape == 1) {
    const float radius = within(random, 0.2f, 0.45f);
    lamp = lamp_of({AreaLight::Shape::kRing, towards_degrees({azimuth * 0.2f, within(random, 0, 15)}), radius,
                    radius * within(random, 0.55f, 0.8f), colour, 1});
    words = "ring";
  } else {
    lamp = lamp_of({AreaLight::Shape::kRectangle, towards, within(random, 0.15f, 0.5f),
                    within(random, 0.15f, 0.5f), colour, 1});
    lamp.roll_rad = within(random, -0.3f, 0.3f);
    words = "softbox key";
  }
  lamp.falloff = within(random, 0.1f, 0.5f);
  return lamp;
}

void add_rims(Random& random, float side, int count, float power, const Vec3f (&colours)[2],
              std::vector<AreaLight>& lamps) {
  for (int k = 0; k < count; ++k) {
    const float azimuth = (k == 0 ? -side : side) * within(random, 115, 160);
    AreaLight rim = lamp_of({AreaLight::Shape::kRectangle, towards_degrees({azimuth, within(random, 0, 35)}),
                             within(random, 0.05f, 0.12f), within(random, 0.35f, 0.7f), colours[k % 2],
                             power * within(random, 0.4f, 1.2f)});
    rim.falloff = 0.2f;
    lamps.push_back(rim);
  }
}

}  // namespace

Painting studio(Random& random, int width_px) {
  std::vector<AreaLight> lamps;
  const float side = random.next() < 0.5f ? 1.0f : -1.0f, kelvin = within(random, 3200, 6500);
  std::string words;
  lamps.push_back(key_light(random, side, light_of_temperature(kelvin), words));
  const Vec3f second = light_of_temperature(within(random, 3200, 7500));
  const float fill = within_ratio(random, 0.08f, 0.7f);
  if (random.next() < 0.8f)
    lamps.push_back(lamp_of({AreaLight::Shape::kRectangle,
                             towards_degrees({-side * within(random, 35, 80), within(random, 0, 30)}),
                             within(random, 0.25f, 0.6f), within(random, 0.25f, 0.6f), second, fill}));
  const int rims = below(random, 3);
  add_rims(random, side, rims, 0.5f, {second, light_of_temperature(5500)}, lamps);
  if (random.next() < 0.4f)
    lamps.push_back(lamp_of({AreaLight::Shape::kRectangle, towards_degrees({0, within(random, 72, 88)}),
                             within(random, 0.3f, 0.7f), within(random, 0.2f, 0.4f), second,
                             within(random, 0.1f, 0.5f)}));
  float power = 0;
  for (const AreaLight& lamp : lamps)
    power += luminance(lamp.radiance) * static_cast<float>(solid_angle_of(lamp));
  const float grey = power * within_ratio(random, 0.004f, 0.06f);
  const Vec3f tint = light_of_temperature(within(random, 4500, 6500));
  const Backdrop backdrop{tint * grey, tint * (grey * within(random, 0.6f, 2.5f)), random.next_bits()};
  Image map =
      painted(width_px, kPaintSamples, [&](Vec3f way) { return with_lamps(lamps, way, backdrop.at(way)); });
  return {std::move(map), fmt::format("studio, {} of {:.0f} K, {} lamps, {} of them rims", words, kelvin,
                                      lamps.size(), rims)};
}

namespace {

struct Glow {
  Vec3f towards, radiance;
  float sharpness;
};

/// Its energy, 2 pi / sharpness x (1 - exp(-2 sharpness)), is drawn, not its peak. `colour`: draws one.
template <class Colour>
Glow draw_glow(Random& random, const Colour& colour) {
  const Vec3f towards = towards_degrees({within(random, -180, 180), within(random, -25, 60)});
  const float sharpness = within_ratio(random, 2, 40);
  const float energy = within_ratio(random, 0.2f, 1);
  return {towards, colour() * (energy * sharpness / (2 * kPi * (1 - std::exp(-2 * sharpness)))), sharpness};
}

}  // namespace

Painting coloured_lamps(Random& random, int width_px) {
  std::vector<Glow> glows;
  std::vector<AreaLight> lamps;
  const float first = random.next(), apart = within(random, 0.2f, 0.5f);
  const int hues = 2 + below(random, 2);
  const auto colour = [&](int k) {
    const float hue = first + apart * static_cast<float>(k % hues) + within(random, -0.04f, 0.04f);
    return hue_of(hue, within(random, 0.4f, 0.95f));
  };
  const int glow_count = 2 + below(random, 3), lamp_count = below(random, 4);
  glows.reserve(static_cast<size_t>(glow_count));
  for (int k = 0; k < glow_count; ++k) glows.push_back(draw_glow(random, [&] { return colour(k); }));
  for (int k = 0; k < lamp_count; ++k) {
    const bool is_disc = random.next() < 0.3f;
    const float half = within_ratio(random, 0.06f, 0.4f);
    const Vec3f towards = towards_degrees({within(random, -150, 150), within(random, 0, 50)});
    lamps.push_back(
        lamp_of({is_disc ? AreaLight::Shape::kDisc : AreaLight::Shape::kRectangle, towards, half,
                 within_ratio(random, 0.06f, 0.5f), colour(k + 1), within_ratio(random, 0.2f, 1)}));
  }
  const Vec3f first_hue = colour(0), second_hue = colour(1);
  const Vec3f above = first_hue * within(random, 0.01f, 0.06f);
  const Vec3f under = second_hue * within(random, 0.01f, 0.06f);
  Image map = painted(width_px, kPaintSamples, [&](Vec3f way) {
    const float up = smooth(-0.6f, 0.6f, way.y);
    Vec3f light = above * up + under * (1 - up);
    for (const Glow& glow : glows)
      light += glow.radiance * std::exp(glow.sharpness * (dot(way, glow.towards) - 1));
    return with_lamps(lamps, way, light);
  });
  return {std::move(map),
          fmt::format("{} hues from {:.2f}, {} glows, {} lamps", hues, first, glow_count, lamp_count)};
}

Vec3f hue_of(float hue_turns, float saturation) {
  Vec3f rgb;
  for (int c = 0; c < 3; ++c) {
    const float away = std::fabs(fraction_of(hue_turns - static_cast<float>(c) / 3 + 0.5f) - 0.5f) * 6;
    rgb[c] = 1 - saturation * std::clamp(away - 1, 0.0f, 1.0f);
  }
  return rgb / luminance(rgb);
}

Vec3f light_of_temperature(float kelvin) {
  const double t = static_cast<double>(kelvin), t2 = t * t, t3 = t2 * t;
  const double x = t <= 4000 ? -0.2661239e9 / t3 - 0.2343589e6 / t2 + 0.8776956e3 / t + 0.179910
                             : -3.0258469e9 / t3 + 2.1070379e6 / t2 + 0.2226347e3 / t + 0.240390;
  const double y = t <= 2222   ? -1.1063814 * x * x * x - 1.34811020 * x * x + 2.18555832 * x - 0.20219683
                   : t <= 4000 ? -0.9549476 * x * x * x - 1.37418593 * x * x + 2.09137015 * x - 0.16748867
                               : 3.0817580 * x * x * x - 5.87338670 * x * x + 3.75112997 * x - 0.37001483;
  const double cie_x = x / y, cie_z = (1 - x - y) / y;
  Vec3f rgb{static_cast<float>(3.2406 * cie_x - 1.5372 - 0.4986 * cie_z),
            static_cast<float>(-0.9689 * cie_x + 1.8758 + 0.0415 * cie_z),
            static_cast<float>(0.0557 * cie_x - 0.2040 + 1.0570 * cie_z)};
  for (int c = 0; c < 3; ++c) rgb[c] = std::max(rgb[c], 0.0f);
  return rgb / luminance(rgb);
}

}  // namespace ohb::environments
