#include "dataset/model/camera.h"

#include <algorithm>
#include <cmath>

namespace ohb {
namespace {

constexpr float kMargin = 1.05f;

// A point at radius r and height y stays in frame at every turn if both |x| <= (d - z) t on the circle of
// radius r and |y| <= (d - r) t: d >= r sqrt(1 + 1 / t^2) and d >= r + |y| / t.
float distance_for(float radius, float height, float t) {
  return std::max(radius * std::sqrt(1 + 1 / (t * t)), radius + std::abs(height) / t);
}

}  // namespace

Camera fit_camera(const std::vector<Vec3f>& positions_cm) {
  const Bounds bounds = bounds_of(positions_cm);
  Camera camera;
  camera.half_width = kSensorMm / 2 / kLensMm;
  camera.center_y_cm = 0.5f * (bounds.low.y + bounds.high.y);
  const float t = camera.half_width / kMargin;
  for (const Vec3f& p : positions_cm)
    camera.distance_cm =
        std::max(camera.distance_cm, distance_for(std::hypot(p.x, p.z), p.y - camera.center_y_cm, t));
  return camera;
}

double turn_of_view(int view, int view_count) {
  return 2 * 3.14159265358979323846 * view / view_count;
}

Vec3f turn_about_y(Vec3f v, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {static_cast<float>(c * v.x + s * v.z), v.y, static_cast<float>(c * v.z - s * v.x)};
}

}  // namespace ohb
