#include "renderer/footprint.h"

#include <algorithm>
#include <cmath>

namespace ohb::renderer {

std::vector<uint8_t> footprint(const Scene& scene, const ViewCamera& view, int size_px) {
  // Far more than rounding moves a projected corner or a ray.
  constexpr float kMargin_px = 0.05f;
  const size_t pixels = static_cast<size_t>(size_px) * size_px;
  std::vector<Vec2f> corners(scene.positions.size() - 1);
  for (size_t i = 0; i < corners.size(); ++i)
    if (!view.project(scene.positions[i], corners[i])) return std::vector<uint8_t>(pixels, 1);
  std::vector<uint8_t> seen(pixels, 0);
  const auto clamped = [&](float v) {
    return static_cast<int>(std::floor(std::clamp(v, -1.0f, static_cast<float>(size_px))));
  };
  for (size_t t = 0; t < scene.indices.size(); t += 3) {
    const Vec2f a = corners[scene.indices[t]], b = corners[scene.indices[t + 1]],
                c = corners[scene.indices[t + 2]];
    const int x0 = std::max(0, clamped(std::min({a.x, b.x, c.x}) - kMargin_px)),
              x1 = std::min(size_px - 1, clamped(std::max({a.x, b.x, c.x}) + kMargin_px)),
              y0 = std::max(0, clamped(std::min({a.y, b.y, c.y}) - kMargin_px)),
              y1 = std::min(size_px - 1, clamped(std::max({a.y, b.y, c.y}) + kMargin_px));
    for (int y = y0; y <= y1; ++y)
      if (x0 <= x1)
        std::fill(&seen[static_cast<size_t>(y) * size_px + x0],
                  &seen[static_cast<size_t>(y) * size_px + x1] + 1, 1);
  }
  return seen;
}

}  // namespace ohb::renderer
