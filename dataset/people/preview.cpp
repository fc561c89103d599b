// What a person looks like, small, by the project's renderer.
#include <algorithm>
#include <cmath>

#include "dataset/model/colour.h"
#include "dataset/people/scan_files.h"
#include "renderer/render.h"

namespace ohb::people {
namespace {

constexpr int kMap_px = 512;

/// The picture, smaller, and the paper's roughness everywhere (previews need no more).
TextureSet small_maps(const ByteImage& picture) {
  TextureSet set;
  set.name = "atlas";
  set.albedo = Image(kMap_px, kMap_px, 3);
  const int step = std::max(1, picture.width_px / kMap_px);
  for (int y = 0; y < kMap_px; ++y)
    for (int x = 0; x < kMap_px; ++x) {
      const int column = std::min(x * step + step / 2, picture.width_px - 1);
      const int row = std::min(y * step + step / 2, picture.height_px - 1);
      const uint8_t* from =
          &picture.values[3 * (static_cast<size_t>(row) * static_cast<size_t>(picture.width_px) +
                               static_cast<size_t>(column))];
      for (int c = 0; c < 3; ++c)
        set.albedo.pixel(x, y)[c] = srgb_to_linear(static_cast<float>(from[c]) / 255);
    }
  const auto constant = [](float value) {
    Image image(kMap_px, kMap_px, 1);
    std::fill(image.values.begin(), image.values.end(), value);
    return image;
  };
  set.roughness = constant(.6f), set.specular = constant(.2f), set.sss = constant(0);
  set.displacement = constant(0), set.valid = constant(1);
  return set;
}

Environment soft_light() {
  Environment light;
  light.name = "soft";
  light.radiance = Image(32, 16, 3);
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 32; ++x) {
      const Vec3f way =
          environment_direction({(static_cast<float>(x) + .5f) / 32, (static_cast<float>(y) + .5f) / 16});
      const float key = std::max(0.0f, dot(way, normalised(Vec3f{-.5f, .6f, .8f})));
      const float value = .5f + .35f * way.y + 1.6f * key * key * key;
      for (int c = 0; c < 3; ++c) light.radiance.pixel(x, y)[c] = value;
    }
  return light;
}

}  // namespace

ByteImage preview(const ScannedPerson& scan, int size_px) {
  Model model;
  model.name = "preview";
  model.positions_cm = scan.positions_cm;
  model.uvs = scan.uvs;
  for (uint32_t face = 0; face < scan.face_count(); ++face)
    for (uint32_t c = scan.face_begin[face] + 1; c + 1 < scan.face_begin[face + 1]; ++c) {
      const Corner corners[3] = {scan.corners[scan.face_begin[face]], scan.corners[c], scan.corners[c + 1]};
      ModelTriangle triangle{};
      for (int k = 0; k < 3; ++k) triangle.position[k] = corners[k].position, triangle.uv[k] = corners[k].uv;
      triangle.material_class = scan.face_class[face], triangle.source_face = face;
      model.triangles.push_back(triangle);
    }
  model.sets.push_back(small_maps(scan.picture));
  renderer::RenderSettings settings;
  settings.size_px = size_px;
  settings.spp = 16;
  settings.max_bounces = 1;
  settings.subsurface = false;
  const auto scene = renderer::build_scene(model);
  const auto lights = renderer::prepare_lights({soft_light()}, {});
  const Camera camera = fit_camera(model.positions_cm);
  const Sample maps = renderer::render_maps(*scene, camera, 0, [&] {
    renderer::RenderSettings coarse = settings;
    coarse.map_grid = 2;
    return coarse;
  }());
  const std::vector<SampleLight> images = renderer::render_lights({*scene, *lights, camera, 0}, settings);
  ByteImage out(size_px, size_px, 3);
  constexpr float kBackground = .35f;
  for (size_t i = 0; i < static_cast<size_t>(size_px) * static_cast<size_t>(size_px); ++i)
    for (size_t c = 0; c < 3; ++c) {
      const float linear = images[0].radiance.values[3 * i + c] + (1 - maps.mask.values[i]) * kBackground;
      out.values[3 * i + c] =
          static_cast<uint8_t>(std::lround(255 * linear_to_srgb(std::clamp(linear, 0.0f, 1.0f))));
    }
  return out;
}

}  // namespace ohb::people
