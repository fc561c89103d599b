#include "renderer/validation/cycles_scene.h"

#include <Imath/half.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "dataset/model/atomic_file.h"
#include "dataset/model/json_text.h"
#include "dataset/model/model_files.h"
#include "dataset/model/sampling.h"
#include "dataset/model/scattering.h"

namespace ohb::validation {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

constexpr float kMetrePerCm = 0.01f;
constexpr int kGuardedSeeds = 1 << 16;

Vec3f to_blender(Vec3f p_cm) {
  return {p_cm.x * kMetrePerCm, -p_cm.z * kMetrePerCm, p_cm.y * kMetrePerCm};
}

json to_json(Vec3f v) {
  return {v.x, v.y, v.z};
}

template <class T>
void write_array(const fs::path& file, const std::vector<T>& values) {
  static_assert(sizeof(T) % 4 == 0);
  write_file_atomically(file,
                        std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)));
}

bool is_drawable(const ModelTriangle& t) {
  return t.position[0] != t.position[1] && t.position[1] != t.position[2] && t.position[2] != t.position[0];
}

json write_mesh(const fs::path& folder, const Model& model) {
  std::vector<Vec3f> positions;
  for (const Vec3f& p : model.positions_cm) positions.push_back(to_blender(p));
  std::vector<int32_t> triangles, sets;
  std::vector<Vec2f> corner_uvs;
  for (const ModelTriangle& triangle : model.triangles) {
    if (!is_drawable(triangle)) continue;
    for (int c = 0; c < 3; ++c) {
      triangles.push_back(static_cast<int32_t>(triangle.position[c]));
      corner_uvs.push_back(model.uvs[triangle.uv[c]]);
    }
    sets.push_back(triangle.set);
  }
  write_array(folder / "positions.f32", positions);
  write_array(folder / "triangles.i32", triangles);
  write_array(folder / "corner_uvs.f32", corner_uvs);
  write_array(folder / "sets.i32", sets);
  return {{"positions", "positions.f32"},
          {"triangles", "triangles.i32"},
          {"corner_uvs", "corner_uvs.f32"},
          {"sets", "sets.i32"}};
}

bool is_constant(const Image& image) {
  for (size_t i = image.channels; i < image.values.size(); ++i)
    if (image.values[i] != image.values[i - image.channels]) return false;
  return true;
}

void write_map(const fs::path& file, const Image& image, ExrPart::Type type) {
  ExrPart part;
  part.name = "map";
  part.channels =
      image.channels == 1 ? std::vector<std::string>{"Y"} : std::vector<std::string>{"R", "G", "B"};
  part.type = type;
  part.image = image;
  if (is_constant(image)) {
    part.image = Image(1, 1, image.channels);
    std::copy_n(image.values.begin(), image.channels, part.image.values.begin());
  }
  write_exr(file, {part}, {});
}

/// The subsurface map as the renderer's texels hold it.
Image as_in_texels(Image sss) {
  for (float& value : sss.values) value = static_cast<float>(half(scattering_of(value)));
  return sss;
}

json write_texture_set(const fs::path& folder, const TextureSet& set, size_t number) {
  json description = {{"name", set.name}};
  for (const MapKind& kind : kMapKinds) {
    const Image& image = set.*kind.image;
    if (kind.image == &TextureSet::displacement) continue;
    if (image.values.empty()) {
      description[kind.name] = nullptr;
      continue;
    }
    const std::string file = "maps/" + std::to_string(number) + "_" + kind.name + ".exr";
    // Cycles 3.4 reads a half of 0 as 2^-15 (measured), more than kLeastSubsurface: all would scatter.
    if (kind.image == &TextureSet::sss)
      write_map(folder / file, as_in_texels(image), ExrPart::Type::kFloat);
    else
      write_map(folder / file, image, ExrPart::Type::kHalf);
    description[kind.name] = file;
  }
  return description;
}

json write_environment(const fs::path& folder, const Environment* environment) {
  if (!environment) return nullptr;
  // Not write_map: Cycles wants the size that the importance table has.
  write_exr(folder / "environment.exr",
            {{"map", {"R", "G", "B"}, ExrPart::Type::kFloat, environment->radiance}}, {});
  return {{"file", "environment.exr"}, {"width_px", environment->radiance.width_px}};
}

json describe_points(const std::vector<renderer::PointLight>& points) {
  json list = json::array();
  for (const renderer::PointLight& point : points)
    list.push_back({{"position", to_json(to_blender(point.position_cm))},
                    {"intensity", to_json({point.intensity, point.intensity, point.intensity})}});
  return list;
}

json describe_camera(const Camera& camera) {
  return {{"location", to_json(to_blender({0, camera.center_y_cm, camera.distance_cm}))},
          {"sensor_mm", kSensorMm},
          {"lens_mm", kSensorMm / 2 / camera.half_width},
          {"clip_start", 1e-3 * camera.distance_cm * kMetrePerCm},
          {"clip_end", 100.0 * camera.distance_cm * kMetrePerCm}};
}

json describe_pass(const CyclesPass& pass) {
  json boxes = json::array();
  for (const renderer::PixelBox& box : pass.boxes) boxes.push_back({box.x0, box.y0, box.x1, box.y1});
  return {{"spp", pass.spp},
          {"seeds", pass.seeds},
          {"boxes", boxes},
          {"adaptive_threshold", pass.adaptive_threshold}};
}

}  // namespace

std::vector<uint32_t> cycles_seeds(uint64_t seed, int count) {
  std::vector<uint32_t> seeds;
  for (uint64_t i = 0; static_cast<int>(seeds.size()) < std::min(count, kGuardedSeeds); ++i) {
    const uint32_t candidate = static_cast<uint32_t>(mix_bits(mix_bits(seed) + i) >> 33);
    if (std::find(seeds.begin(), seeds.end(), candidate) == seeds.end()) seeds.push_back(candidate);
  }
  return seeds;
}

void write_cycles_scene(const fs::path& folder, const CyclesScene& scene) {
  fs::create_directories(folder / "maps");
  json description = {{"format", "openhumanbrdf validation scene 1"},
                      {"model", scene.shading == renderer::ShadingModel::kV1 ? "v1" : "v2"},
                      {"mesh", write_mesh(folder, *scene.model)},
                      {"texture_sets", json::array()},
                      {"sss_scale", scene.subsurface ? 1.0 : 0.0},
                      {"environment", write_environment(folder, scene.environment)},
                      {"points", describe_points(scene.points)},
                      {"camera", describe_camera(scene.camera)},
                      {"turn", scene.turn_rad},
                      {"size_px", scene.size_px},
                      {"bounces", scene.max_bounces},
                      {"numbers", scene.numbers == CyclesNumbers::kTables ? "tables" : "scrambled"},
                      {"passes", json::array()},
                      {"kept", scene.kept.empty() ? json(nullptr) : json(scene.kept)},
                      {"output", "renders"}};
  for (size_t i = 0; i < scene.model->sets.size(); ++i)
    description["texture_sets"].push_back(write_texture_set(folder, scene.model->sets[i], i));
  for (const CyclesPass& pass : scene.passes) description["passes"].push_back(describe_pass(pass));
  write_file_atomically(folder / "scene.json", json_text(description, 1) + "\n");
}

}  // namespace ohb::validation
