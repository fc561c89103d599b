// Small models made in memory.
#pragma once

#include <cmath>
#include <functional>

#include "dataset/model/model.h"
#include "dataset/model/regions.h"

namespace ohb {

struct TestMaterial {
  Vec3f albedo{0.8f, 0.4f, 0.2f};
  float roughness = 0.5f, specular = 0.2f, sss = 0;
};

/// A texture set of constant maps.
inline TextureSet constant_set(const TestMaterial& material, int size_px = 4) {
  TextureSet set;
  set.name = "constant";
  set.albedo = Image(size_px, size_px, 3);
  for (size_t i = 0; i < set.albedo.values.size(); ++i)
    set.albedo.values[i] = material.albedo[static_cast<int>(i % 3)];
  const auto constant = [&](float value) {
    Image image(size_px, size_px, 1);
    for (float& v : image.values) v = value;
    return image;
  };
  set.roughness = constant(material.roughness);
  set.specular = constant(material.specular);
  set.sss = constant(material.sss);
  set.displacement = constant(0);
  set.valid = constant(1);
  return set;
}

inline ModelTriangle triangle_of(uint32_t a, uint32_t b, uint32_t c, uint16_t set = 0) {
  return {{a, b, c}, {a, b, c}, set, kSkin, 0};
}

/// A grid of (columns + 1) x (rows + 1) positions with one UV each.
inline Model grid_model(int columns, int rows, const std::function<Vec3f(float u, float v)>& position,
                        const TextureSet& set) {
  Model model;
  model.name = "grid";
  model.sets = {set};
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i <= columns; ++i) {
      const Vec2f uv{static_cast<float>(i) / static_cast<float>(columns),
                     static_cast<float>(j) / static_cast<float>(rows)};
      model.uvs.push_back(uv);
      model.positions_cm.push_back(position(uv.x, uv.y));
    }
  const auto index = [&](int i, int j) { return static_cast<uint32_t>(j * (columns + 1) + i); };
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      model.triangles.push_back(triangle_of(index(i, j), index(i + 1, j), index(i + 1, j + 1)));
      model.triangles.push_back(triangle_of(index(i, j), index(i + 1, j + 1), index(i, j + 1)));
    }
  for (size_t t = 0; t < model.triangles.size(); ++t)
    model.triangles[t].source_face = static_cast<uint32_t>(t);
  return model;
}

/// A square of the given edge facing +Z at z = 0, centred on the Y axis at height edge / 2.
inline Model plane_model(float edge_cm, const TextureSet& set) {
  return grid_model(
      1, 1,
      [=](float u, float v) {
        return Vec3f{(u - 0.5f) * edge_cm, v * edge_cm, 0};
      },
      set);
}

/// A sphere that touches y = 0 (its poles are on the Y axis, its UV seam at -X... positions there coincide).
inline Model sphere_model(float radius_cm, int columns, const TextureSet& set) {
  Model model = grid_model(
      columns, columns / 2,
      [=](float u, float v) {
        const float phi = -6.2831853f * u, theta = 3.1415927f * (1 - v);
        return Vec3f{radius_cm * std::sin(theta) * std::cos(phi), radius_cm + radius_cm * std::cos(theta),
                     radius_cm * std::sin(theta) * std::sin(phi)};
      },
      set);
  // Columns 0 and `columns` are the same place: share the positions, keep the UVs.
  for (ModelTriangle& triangle : model.triangles)
    for (uint32_t& p : triangle.position)
      if (p % static_cast<uint32_t>(columns + 1) == static_cast<uint32_t>(columns))
        p -= static_cast<uint32_t>(columns);
  return model;
}

/// The same radiance from everywhere.
inline Image constant_radiance(Vec3f radiance, int height_px = 8) {
  Image image(2 * height_px, height_px, 3);
  for (size_t i = 0; i < image.values.size(); ++i) image.values[i] = radiance[static_cast<int>(i % 3)];
  return image;
}

}  // namespace ohb
