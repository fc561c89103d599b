// Maps of computed light.
#pragma once

#include <functional>

#include "dataset/model/image.h"
#include "dataset/model/vec.h"

namespace ohb::environments {

/// Radiance (linear Rec. 709) that arrives from a unit direction.
using RadianceOf = std::function<Vec3f(Vec3f direction)>;

/// Each texel is the mean over samples x samples directions that divide its solid angle evenly; where these
/// differ, over four times as many. All threads, the same bits for any number of them.
Image painted(int width_px, int samples, const RadianceOf& radiance);

/// Adds a disc of even radiance whose irradiance on a plane that faces it is `irradiance`: on each texel the
/// share of it that the disc covers, then all scaled so that the map's energy grows by exactly what the disc
/// sends, irradiance x 2 / (1 + cos radius) (a small disc's is its irradiance).
void add_disc(Image& map, Vec3f towards, float radius_rad, Vec3f irradiance);

/// The sun's mean angular radius, in radians (0.2666 degrees).
constexpr float kSunRadius_rad = 0.004653f;

}  // namespace ohb::environments
