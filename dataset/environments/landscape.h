// What stands below and around a sky: ground, and a skyline of hills, trees or houses.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "dataset/environments/painting.h"
#include "dataset/model/sampling.h"
#include "dataset/model/vec.h"

namespace ohb::environments {

struct Landscape {
  enum class Skyline { kHills, kTrees, kHouses };
  std::string ground;  // "grass", "asphalt", ...
  Vec3f albedo;
  float roughness = 0.3f;  // of the ground's light and dark
  Skyline skyline = Skyline::kHills;
  float skyline_height = 0.1f;  // tangent of its highest angle
  Vec3f skyline_albedo;
  uint64_t pattern = 0;  // of the noise

  std::string words() const;
};

Landscape draw_landscape(Random& random);

/// Irradiance of the upper half of the sky on the ground, by 64 x 256 directions.
Vec3f irradiance_from_above(const RadianceOf& sky);

/// Light of the ground and skyline under a sky: Lambert surfaces lit by `on_ground` (sky and sun), the
/// skyline by half of it, both fading into the haze at the horizon. Where the sky is seen: false.
bool sees_landscape(const Landscape& landscape, Vec3f direction, Vec3f on_ground, Vec3f haze,
                    Vec3f& radiance);

/// Sum of `octaves` of value noise of halving size and weight, mean about 0.5, in [0, 1].
float fractal_noise(Vec3f p, int octaves, uint64_t which);

}  // namespace ohb::environments
