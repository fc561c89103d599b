#include "dataset/exports/realism.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "dataset/exports/encodings.h"
#include "dataset/exports/grid.h"
#include "dataset/model/colour.h"
#include "dataset/model/data_files.h"
#include "dataset/model/interrupt.h"
#include "dataset/model/progress.h"
#include "dataset/model/regions.h"
#include "renderer/render.h"

namespace ohb::exports {
namespace {

constexpr size_t kPeople = 3;
constexpr int kSteps = 4;
constexpr float kDefaultValue = 0.5F;  // of roughness and specular in Blender's Principled BSDF
constexpr float kHeadShare = 0.17F;    // of a person's height that the picture of the head shows

/// The model as it is after so many of the steps beyond the first.
Model after_steps(Model model, int steps) {
  for (TextureSet& set : model.sets) {
    if (steps < 3) set.normal = Image();
    if (steps < 1)
      for (Image* map : {&set.roughness, &set.specular})
        std::fill(map->values.begin(), map->values.end(), kDefaultValue);
  }
  return model;
}

/// Where the head is, by its hair; of a bald person the uppermost part, which a raised hand can be.
Vec3f head_of(const Model& model, float height_cm) {
  Vec3f highest{0, 0, 0};
  bool has_hair = false;
  for (const ModelTriangle& triangle : model.triangles) {
    const bool is_hair = triangle.material_class == static_cast<uint8_t>(MaterialClass::kHair);
    for (const uint32_t position : triangle.position) {
      const Vec3f p = model.positions_cm[position];
      if ((is_hair && !has_hair) || (is_hair == has_hair && p.y > highest.y)) highest = p;
      has_hair = has_hair || is_hair;
    }
  }
  return {highest.x, highest.y - 0.4F * kHeadShare * height_cm, highest.z};
}

/// Settings of the head's picture, as large as the whole person's of these settings: a square around it, cut
/// from an image of a finer grid.
renderer::RenderSettings head_settings(const Model& model, const Camera& camera,
                                       renderer::RenderSettings settings) {
  const float height_cm = bounds_of(model.positions_cm).high.y;
  const Vec3f head = head_of(model, height_cm);
  const float frame_cm = 2 * camera.half_width * (camera.distance_cm - head.z);
  const int picture_px = settings.size_px;
  const float px_a_cm = static_cast<float>(picture_px) / (kHeadShare * height_cm);
  settings.size_px = static_cast<int>(std::lround(frame_cm * px_a_cm));
  const auto corner = [&](float cm) {
    const int centre = static_cast<int>(std::lround((0.5F * frame_cm + cm) * px_a_cm));
    return std::clamp(centre - picture_px / 2, 0, settings.size_px - picture_px);
  };
  const int x0 = corner(head.x), y0 = corner(camera.center_y_cm - head.y);
  settings.crop = {x0, y0, x0 + picture_px, y0 + picture_px};
  return settings;
}

ByteImage picture_of(const renderer::LitView& view, const renderer::RenderSettings& settings) {
  const auto alive = [](size_t) { throw_if_interrupted(); };
  const Image radiance = renderer::render_lights(view, settings, nullptr, alive).front().radiance;
  const renderer::PixelBox box =
      settings.crop.x1 > 0 ? settings.crop : renderer::PixelBox{0, 0, settings.size_px, settings.size_px};
  Image picture(box.x1 - box.x0, box.y1 - box.y0, 3);
  for (int y = box.y0; y < box.y1; ++y)
    for (int x = box.x0; x < box.x1; ++x)
      for (int c = 0; c < 3; ++c)
        picture.pixel(x - box.x0, y - box.y0)[c] =
            std::clamp(linear_to_srgb(radiance.pixel(x, y)[c]), 0.0F, 1.0F);
  return thumbnail(picture, picture.width_px);
}

void add_person(const std::filesystem::path& folder, const renderer::LightSet& lights,
                renderer::RenderSettings settings, const std::function<void(ByteImage)>& add) {
  const Model model = read_model(folder, ModelParts::kForRendering);
  const Camera camera = fit_camera(model.positions_cm);
  for (int steps = 0; steps < kSteps; ++steps) {
    const auto scene = renderer::build_scene(after_steps(model, steps));
    settings.subsurface = steps >= 2;
    const renderer::LitView view{*scene, lights, camera, 0};
    add(picture_of(view, settings));
    add(picture_of(view, head_settings(model, camera, settings)));
  }
}

}  // namespace

const std::vector<std::string>& realism_steps() {
  static const std::vector<std::string> kNames = {"the scan as it came", "the classes' materials",
                                                  "light under the skin", "the surface's detail"};
  return kNames;
}

ByteImage realism_figure(const SampleIndex& index, const RealismPictures& pictures, bool quiet) {
  std::vector<std::filesystem::path> models;
  for (const IndexedPerson& person : index.people)
    if (!person.model.empty() && std::filesystem::is_directory(person.model)) models.push_back(person.model);
  if (models.size() < kPeople) return {};
  models = {models.front(), models[models.size() / 2], models.back()};
  const auto lights =
      renderer::prepare_lights({read_environment(program_file("assets/environments/studio.exr"))}, {});
  Progress progress("realism figure", 2 * kSteps * models.size(), quiet);
  std::vector<ByteImage> cells;
  const auto add = [&](ByteImage picture) {
    cells.push_back(std::move(picture));
    progress.add();
  };
  renderer::RenderSettings settings;
  settings.size_px = pictures.size_px;
  settings.spp = pictures.spp;
  settings.adaptive = true;
  for (const std::filesystem::path& model : models) add_person(model, *lights, settings, add);
  return grid_of(cells, 2 * kSteps);
}

}  // namespace ohb::exports
