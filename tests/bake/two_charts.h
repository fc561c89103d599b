// A surface with a seam, and maps on it.
#pragma once

#include <cmath>
#include <vector>

#include "bake/seam_fill.h"
#include "bake/source_bake.h"
#include "dataset/surface/padding.h"
#include "tests/bake/test_scans.h"

namespace ohb {
using namespace bake;
using namespace surface;

/// A bent sheet in two charts, the right one turned by `degrees`, smaller, and mirrored on demand.
struct TwoCharts {
  Model model;
  std::vector<uint32_t> triangles;
  std::vector<UvTriangle> uvs;
  TexelCoverage coverage;
  std::vector<uint8_t> is_covered, is_inside;
  MeshFrames frames;
  std::vector<Seam> seams;

  TwoCharts(int size_px, float degrees, bool is_mirrored) {
    model = height_field(8, 10, [](float x, float y) { return 0.05f * x * x + 0.03f * x * y; });
    const float cosine = std::cos(degrees * 0.0174533f), sine = std::sin(degrees * 0.0174533f);
    std::vector<Vec2f> uvs_of_right = model.uvs;
    for (Vec2f& uv : uvs_of_right) {
      Vec2f p{(uv.x - 0.75f) * 0.4f, (uv.y - 0.5f) * 0.4f};
      if (is_mirrored) p.x = -p.x;
      uv = {0.72f + cosine * p.x - sine * p.y, 0.5f + sine * p.x + cosine * p.y};
    }
    const uint32_t offset = static_cast<uint32_t>(model.uvs.size());
    for (size_t i = 0; i < offset; ++i)
      model.uvs[i] = {0.05f + 0.6f * model.uvs[i].x, 0.1f + 0.8f * model.uvs[i].y};
    model.uvs.insert(model.uvs.end(), uvs_of_right.begin(), uvs_of_right.end());
    for (ModelTriangle& triangle : model.triangles) {
      float x = 0;
      for (uint32_t p : triangle.position) x += model.positions_cm[p].x / 3;
      if (x > 5)
        for (uint32_t& uv : triangle.uv) uv += offset;
      triangles.push_back(static_cast<uint32_t>(triangles.size()));
      uvs.push_back({{model.uvs[triangle.uv[0]], model.uvs[triangle.uv[1]], model.uvs[triangle.uv[2]]}});
    }
    coverage = cover_texels(uvs, size_px, size_px);
    for (size_t i = 0; i < coverage.owner.size(); ++i) {
      is_covered.push_back(coverage.owner[i] != TexelCoverage::kNone);
      is_inside.push_back(coverage.flags[i] & TexelCoverage::kCentre);
    }
    frames = frames_of(model);
    seams = find_seams(model, triangles, &frames);
  }

  /// Values of a function of position at the covered texels.
  template <typename Function>
  Image map_of(const Function& function) const {
    Image map(coverage.width_px, coverage.height_px, 3);
    for (int row = 0; row < map.height_px; ++row)
      for (int x = 0; x < map.width_px; ++x) {
        const uint32_t owner = coverage.owner_of(x, row);
        if (owner == TexelCoverage::kNone) continue;
        // Beyond the triangle's border too: the texel's own place in the triangle's plane.
        const TexelTriangle t = to_texel_space(uvs[owner], map.width_px, map.height_px);
        const TexelPoint p{x + 0.5, map.height_px - row - 0.5},
            a = t.corner[1] - t.corner[0], b = t.corner[2] - t.corner[0], q = p - t.corner[0];
        const double area = a.x * b.y - a.y * b.x;
        const float v = static_cast<float>((q.x * b.y - q.y * b.x) / area);
        const float w = static_cast<float>((a.x * q.y - a.y * q.x) / area);
        const float weights[3] = {1 - v - w, v, w};
        Vec3f position, normal, tangent;
        for (int c = 0; c < 3; ++c) {
          position += weights[c] * model.positions_cm[model.triangles[owner].position[c]];
          normal += weights[c] * frames.normals[model.triangles[owner].position[c]];
          tangent += weights[c] * frames.tangents[3 * owner + c].tangent;
        }
        const Vec3f value = function(position, tangent, normal, frames.tangents[3 * owner].sign);
        for (int c = 0; c < 3; ++c) map.pixel(x, row)[c] = value[c];
      }
    return map;
  }

  Image filled(Image map, bool is_normals) const {
    const SeamBand band(seams, is_covered, map.width_px, map.height_px);
    pad(map, band.fill(map, is_covered, is_normals));
    return map;
  }
};

inline Vec3f smooth_colour(Vec3f p, Vec3f, Vec3f, float) {
  return {0.4f + 0.02f * p.x, 0.5f + 0.2f * std::sin(0.5f * p.y), 0.3f + 0.01f * p.x * p.y / 10};
}

/// One direction of the model everywhere, in each place's own frame.
inline Vec3f steady_normal(Vec3f, Vec3f tangent, Vec3f normal, float sign) {
  return to_tangent_space(normalised({0.3f, 0.2f, 1}), tangent, normal, sign);
}

}  // namespace ohb
