#include "dataset/environments/area_lights.h"

#include <cmath>

namespace ohb::environments {
namespace {

constexpr double kPiDouble = 3.14159265358979323846;

double disc_solid_angle(double tangent) {
  return 2 * kPiDouble * (1 - 1 / std::sqrt(1 + tangent * tangent));
}

}  // namespace

bool shines(const AreaLight& light, Vec3f direction, Vec3f& radiance) {
  const float depth = dot(direction, light.towards);
  // No part of it is farther from its middle than its corner.
  if (depth <= 1e-4f ||
      depth * depth * (1 + light.half_width * light.half_width + light.half_height * light.half_height) <
          0.999f)
    return false;
  const Vec3f up = std::fabs(light.towards.y) > 0.999f ? Vec3f{0, 0, 1} : Vec3f{0, 1, 0};
  const Vec3f right = normalised(cross(up, light.towards)), above = cross(light.towards, right);
  const float x = dot(direction, right) / depth, y = dot(direction, above) / depth;
  float share = 0;  // 0 in the middle, 1 at the corner or rim
  if (light.shape == AreaLight::Shape::kRectangle) {
    const float cosine = std::cos(light.roll_rad), sine = std::sin(light.roll_rad);
    const float u = (cosine * x + sine * y) / light.half_width,
                v = (cosine * y - sine * x) / light.half_height;
    if (std::fabs(u) > 1 || std::fabs(v) > 1) return false;
    share = 0.5f * (u * u + v * v);
  } else {
    const float radius = std::sqrt(x * x + y * y);
    if (radius > light.half_width) return false;
    if (light.shape == AreaLight::Shape::kRing && radius < light.half_height) return false;
    share = radius * radius / (light.half_width * light.half_width);
  }
  radiance = light.radiance * (1 - light.falloff * share);
  return true;
}

double solid_angle_of(const AreaLight& light) {
  const double w = static_cast<double>(light.half_width), h = static_cast<double>(light.half_height);
  switch (light.shape) {
    case AreaLight::Shape::kRectangle:
      return 4 * std::asin(w * h / std::sqrt((1 + w * w) * (1 + h * h)));
    case AreaLight::Shape::kDisc:
      return disc_solid_angle(w);
    case AreaLight::Shape::kRing:
      return disc_solid_angle(w) - disc_solid_angle(h);
  }
  return 0;
}

Vec3f towards_degrees(AzimuthElevation way) {
  const auto a = static_cast<float>(way.azimuth_deg * kPiDouble / 180),
             e = static_cast<float>(way.elevation_deg * kPiDouble / 180);
  return {std::sin(a) * std::cos(e), std::sin(e), std::cos(a) * std::cos(e)};
}

}  // namespace ohb::environments
