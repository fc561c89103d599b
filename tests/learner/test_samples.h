// Small synthetic samples: balls of four materials lit by a directional light.
#pragma once

#include <cmath>
#include <filesystem>
#include <string>

#include "dataset/model/sample.h"

namespace ohb {

/// `kind` varies albedo, size and light: equal arguments give equal samples. Coverage is 1 or 0.
inline Sample ball_sample(int size_px, const std::string& person, int view, int kind = 0) {
  Sample s;
  s.mask = Image(size_px, size_px, 1);
  s.normal = s.diffuse = Image(size_px, size_px, 3);
  s.roughness = s.specular = s.sss = s.displacement = Image(size_px, size_px, 1);
  s.classes = Image(size_px, size_px, 4);
  const float radius = 0.6f + 0.05f * static_cast<float>((kind + view) % 5);
  const float turn = 0.7f * static_cast<float>(view);
  for (const char* name : {"left", "right"}) s.lights.push_back({name, Image(size_px, size_px, 3)});
  for (int y = 0; y < size_px; ++y)
    for (int x = 0; x < size_px; ++x) {
      const float u = (2 * x + 1.0f) / size_px - 1, v = 1 - (2 * y + 1.0f) / size_px;
      const float z2 = radius * radius - u * u - v * v;
      if (z2 <= 0) continue;
      const float z = std::sqrt(z2), n[3] = {u / radius, v / radius, z / radius};
      const int material = v > 0.3f * std::cos(turn) ? 1 : v > 0 ? 0 : 2;
      s.mask.pixel(x, y)[0] = 1;
      s.classes.pixel(x, y)[material] = 1;
      s.roughness.pixel(x, y)[0] = material == 0 ? 0.4f : material == 1 ? 0.5f : 0.85f;
      s.specular.pixel(x, y)[0] = material == 0 ? 0.184f : material == 1 ? 0.239f : 0.263f;
      s.sss.pixel(x, y)[0] = material == 0 ? 0.08f : 0;
      s.displacement.pixel(x, y)[0] = 100 * z;
      for (int c = 0; c < 3; ++c) {
        const float albedo = 0.2f + 0.15f * static_cast<float>((material + c + kind) % 4);
        s.normal.pixel(x, y)[c] = n[c];
        s.diffuse.pixel(x, y)[c] = albedo;
        for (int side = 0; side < 2; ++side)
          s.lights[side].radiance.pixel(x, y)[c] =
              albedo * std::max(0.05f, 0.8f * n[2] + (side ? 0.5f : -0.5f) * n[0] + 0.3f * n[1]);
      }
    }
  s.attributes = {{"ohb:human", person},
                  {"ohb:view", std::to_string(view)},
                  {"ohb:displacementRange_cm", "100"},
                  {"ohb:cameraCenterY_cm", "100"},
                  {"ohb:cameraDistance_cm", "500"},
                  {"ohb:cameraHalfWidth", "0.2"}};
  return s;
}

/// One sub-folder a person, `views` samples each.
inline void write_ball_dataset(const std::filesystem::path& folder, int people, int views, int size_px) {
  for (int p = 0; p < people; ++p) {
    const std::string name = "person" + std::to_string(p);
    std::filesystem::create_directories(folder / name);
    for (int v = 0; v < views; ++v)
      write_sample(folder / name / ("view_00" + std::to_string(v) + ".exr"),
                   ball_sample(size_px, name, v, p));
  }
}

}  // namespace ohb
