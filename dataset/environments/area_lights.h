// Lamps of a studio as the subject sees them: flat shapes that face it.
#pragma once

#include <vector>

#include "dataset/model/vec.h"

namespace ohb::environments {

struct AreaLight {
  enum class Shape { kRectangle, kDisc, kRing };
  Shape shape = Shape::kRectangle;
  Vec3f towards;          // unit direction of its middle
  float roll_rad = 0;     // of a rectangle, about that direction
  float half_width = 0;   // tangent of the half angle; of a disc or ring, its outer radius
  float half_height = 0;  // of a rectangle; of a ring, its inner radius
  Vec3f radiance;         // of its middle
  float falloff = 0;      // share that its corner or rim is darker, 0 to 1
};

/// Radiance from `direction` where the light lies there.
bool shines(const AreaLight& light, Vec3f direction, Vec3f& radiance);

/// Solid angle in sr: a rectangle's 4 asin(w h / sqrt((1 + w^2) (1 + h^2))) (Khadjavi 1968), a disc's
/// 2 pi (1 - cos).
double solid_angle_of(const AreaLight& light);

/// Unit direction: azimuth 0 is the front (+Z), positive to the subject's left (+X).
struct AzimuthElevation {
  float azimuth_deg, elevation_deg;
};
Vec3f towards_degrees(AzimuthElevation way);

}  // namespace ohb::environments
