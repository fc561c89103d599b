#include "dataset/studies/stress_scenes.h"

#include <cmath>
#include <functional>
#include <limits>
#include <map>

#include "dataset/model/error.h"
#include "dataset/model/sampling.h"

namespace ohb::studies {
namespace {

constexpr float kBallRadius_cm = 20;

struct Material {
  Vec3f albedo{0.6f, 0.4f, 0.3f};
  float roughness = 0.5f, specular = 0.2f, sss = 0;
};

Image constant(int size_px, float value) {
  Image image(size_px, size_px, 1);
  std::fill(image.values.begin(), image.values.end(), value);
  return image;
}

TextureSet set_of(const Material& material, int size_px = 4) {
  TextureSet set;
  set.name = "material";
  set.albedo = Image(size_px, size_px, 3);
  for (size_t i = 0; i < set.albedo.values.size(); ++i)
    set.albedo.values[i] = material.albedo[static_cast<int>(i % 3)];
  set.roughness = constant(size_px, material.roughness);
  set.specular = constant(size_px, material.specular);
  set.sss = constant(size_px, material.sss);
  set.displacement = constant(1, 0);
  set.valid = constant(1, 1);
  return set;
}

using Surface = std::function<Vec3f(float u, float v)>;

/// Adds a grid of columns x rows quads, two triangles each, seen from outside where u goes right and v up.
/// `closed`: columns 0 and `columns` share their positions.
void add_grid(Model& model, int columns, int rows, const Surface& surface, uint16_t set = 0,
              bool closed = false) {
  const auto first = static_cast<uint32_t>(model.positions_cm.size());
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i <= columns; ++i) {
      const Vec2f uv{static_cast<float>(i) / static_cast<float>(columns),
                     static_cast<float>(j) / static_cast<float>(rows)};
      model.uvs.push_back(uv);
      model.positions_cm.push_back(surface(uv.x, uv.y));
    }
  const auto corner = [&](int i, int j) { return first + static_cast<uint32_t>(j * (columns + 1) + i); };
  const auto add = [&](int i0, int j0, int i1, int j1, int i2, int j2) {
    ModelTriangle t{};
    const int i[3] = {i0, i1, i2}, j[3] = {j0, j1, j2};
    for (int k = 0; k < 3; ++k) {
      t.uv[k] = corner(i[k], j[k]);
      t.position[k] = corner(closed && i[k] == columns ? 0 : i[k], j[k]);
    }
    t.set = set;
    t.source_face = static_cast<uint32_t>(model.triangles.size());
    model.triangles.push_back(t);
  };
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      add(i, j, i + 1, j, i + 1, j + 1);
      add(i, j, i + 1, j + 1, i, j + 1);
    }
}

/// A ball of which the cap above `open` of its height (0: none, 1: all) is missing.
Model ball(const TextureSet& set, float radius_cm = kBallRadius_cm, int columns = 64, float open = 0) {
  Model model;
  model.name = "ball";
  model.sets = {set};
  add_grid(
      model, columns, columns / 2,
      [=](float u, float v) {
        const float phi = -2 * kPi * u, theta = kPi * (1 - v * (1 - open));
        return Vec3f{radius_cm * std::sin(theta) * std::cos(phi), radius_cm + radius_cm * std::cos(theta),
                     radius_cm * std::sin(theta) * std::sin(phi)};
      },
      0, true);
  return model;
}

/// A square facing +Z, centred at (0, edge / 2, z), leaning back by `lean` about its middle.
void add_square(Model& model, float edge_cm, float z_cm, float lean_rad, uint16_t set) {
  add_grid(
      model, 4, 4,
      [=](float u, float v) {
        const float h = (v - 0.5f) * edge_cm;
        return Vec3f{(u - 0.5f) * edge_cm, 0.5f * edge_cm + h * std::cos(lean_rad),
                     z_cm - h * std::sin(lean_rad)};
      },
      set);
}

/// A closed box of skin of that thickness in z, its front at z = 0.
Model sheet(const TextureSet& set, float edge_cm, float thickness_cm) {
  Model model;
  model.name = "sheet";
  model.sets = {set};
  const Vec3f low{-edge_cm / 2, 0, -thickness_cm}, high{edge_cm / 2, edge_cm, 0};
  const auto at = [=](float x, float y, float z) {
    return Vec3f{low.x + x * (high.x - low.x), low.y + y * (high.y - low.y), low.z + z * (high.z - low.z)};
  };
  for (const Surface& side : std::initializer_list<Surface>{
           [=](float u, float v) { return at(u, v, 1); }, [=](float u, float v) { return at(1 - u, v, 0); },
           [=](float u, float v) { return at(1, v, 1 - u); }, [=](float u, float v) { return at(0, v, u); },
           [=](float u, float v) { return at(u, 1, 1 - v); }, [=](float u, float v) { return at(u, 0, v); }})
    add_grid(model, 1, 1, side);
  return model;
}

/// A sky with a soft sun before and above the subject; `sun` times brighter in one texel if not 0.
Environment sky(float sun = 0) {
  Environment environment;
  environment.name = "sky";
  environment.radiance = Image(64, 32, 3);
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 64; ++x)
      for (int c = 0; c < 3; ++c) {
        const bool bright = x >= 50 && x < 54 && y >= 7 && y < 10;
        environment.radiance.pixel(x, y)[c] =
            (bright && sun == 0 ? 20.0f : 0.3f) +
            0.5f * static_cast<float>(y < 16) * static_cast<float>(c + 1) / 3;
      }
  if (sun > 0)
    for (int c = 0; c < 3; ++c) environment.radiance.pixel(51, 8)[c] = sun;
  return environment;
}

StressScene of(Model model, bool subsurface = false) {
  StressScene scene{std::move(model), sky(), {}, subsurface};
  scene.camera = fit_camera(scene.model.positions_cm);
  return scene;
}

/// A camera at 1 m before a square of 1 m that it sees the middle of.
StressScene before_square(Model model, bool subsurface = false) {
  StressScene scene{std::move(model), sky(), {}, subsurface};
  scene.camera.center_y_cm = 50;
  scene.camera.distance_cm = 100;
  scene.camera.half_width = 0.05f;
  return scene;
}

constexpr Material kSkin{{0.7f, 0.45f, 0.35f}, 0.4f, 0.18f, 0.2f};

StressScene roughness(double at) {
  return of(ball(set_of({{0.3f, 0.2f, 0.1f}, static_cast<float>(at), 0.5f, 0})));
}

StressScene sun(double at) {
  StressScene scene = of(ball(set_of({})));
  scene.environment = sky(static_cast<float>(at));
  return scene;
}

StressScene grazing(double at) {
  Model model;
  model.name = "square";
  model.sets = {set_of({{0.5f, 0.5f, 0.5f}, 0.3f, 0.3f, 0})};
  add_square(model, 100, 0, static_cast<float>(at * M_PI / 180), 0);
  StressScene scene = before_square(std::move(model));
  // So narrow that all is square at 89.9 degrees too, where it is 1.7 mm high.
  scene.camera.half_width = 5e-4f;
  return scene;
}

StressScene tilted_normals(double at) {
  TextureSet set = set_of({{0.5f, 0.4f, 0.3f}, 0.3f, 0.3f, 0}, 16);
  set.normal = Image(16, 16, 3);
  const float tilt = static_cast<float>(at * M_PI / 180);
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 16; ++x) {
      const float phi = 2 * kPi * static_cast<float>((x / 4 + 3 * (y / 4)) % 8) / 8;
      float* n = set.normal.pixel(x, y);
      n[0] = std::sin(tilt) * std::cos(phi), n[1] = std::sin(tilt) * std::sin(phi), n[2] = std::cos(tilt);
    }
  return of(ball(set));
}

StressScene skin_sheet(double at) {
  return before_square(sheet(set_of(kSkin), 100, static_cast<float>(at)), true);
}

StressScene open_ball(double at) {
  // Wax: walks of centimetres, that meet the opening.
  Material wax = kSkin;
  wax.sss = 8;
  StressScene scene = of(ball(set_of(wax), kBallRadius_cm, 64, static_cast<float>(at)), true);
  scene.camera = fit_camera(ball(set_of(wax)).positions_cm);
  return scene;
}

StressScene cloth_gap(double at) {
  Model model = sheet(set_of(kSkin), 100, 10);
  model.sets.push_back(set_of({{0.2f, 0.3f, 0.6f}, 0.9f, 0.25f, 0}));
  add_square(model, 100, static_cast<float>(at), 0, 1);
  return before_square(std::move(model), true);
}

StressScene scale(double at) {
  return of(ball(set_of({}), kBallRadius_cm * static_cast<float>(at)));
}

StressScene far_away(double at) {
  Model model = ball(set_of({}));
  StressScene scene = of(model);
  for (Vec3f& p : scene.model.positions_cm) p.y += static_cast<float>(at);
  scene.camera.center_y_cm += static_cast<float>(at);
  return scene;
}

StressScene triangles(double at) {
  return of(ball(set_of({}), kBallRadius_cm, 2 * static_cast<int>(std::lround(std::sqrt(at) / 2))));
}

StressScene texture(double at) {
  const int size = static_cast<int>(at);
  TextureSet set = set_of({}, size);
  Random random(1, 2, 3);
  for (float& v : set.roughness.values) v = 0.3f + 0.4f * random.next();
  return of(ball(set));
}

/// A bowl, so that light meets it several times.
StressScene albedo(double at) {
  const float a = static_cast<float>(at);
  Model model;
  model.name = "bowl";
  model.sets = {set_of({{a, a, a}, 0.5f, 0.2f, 0})};
  add_grid(model, 24, 24, [](float u, float v) {
    const float x = 2 * u - 1, y = 2 * v - 1;
    return Vec3f{20 * x, 40 * v, 12 * (x * x + y * y)};
  });
  return of(std::move(model));
}

StressScene skin_albedo(double at) {
  Material skin = kSkin;
  const float a = static_cast<float>(at);
  skin.albedo = {a, a, a};
  return of(ball(set_of(skin)), true);
}

/// NaN in that share of the texels of every map and of the environment.
StressScene nan_texels(double at) {
  TextureSet set = set_of(kSkin, 64);
  set.normal = Image(64, 64, 3);
  for (size_t i = 2; i < set.normal.values.size(); i += 3) set.normal.values[i] = 1;
  StressScene scene = of(ball(set), true);
  Random random(7, 8, 9);
  for (TextureSet& s : scene.model.sets)
    for (Image* map : {&s.albedo, &s.normal, &s.roughness, &s.specular, &s.sss, &scene.environment.radiance})
      for (float& v : map->values)
        if (random.next() < at) v = std::numeric_limits<float>::quiet_NaN();
  return scene;
}

}  // namespace

StressScene stress_scene(const std::string& name, double at) {
  static const std::map<std::string, StressScene (*)(double)> scenes = {
      {"roughness", roughness},     {"sun", sun},
      {"grazing", grazing},         {"tilted normals", tilted_normals},
      {"skin sheet", skin_sheet},   {"open ball", open_ball},
      {"cloth gap", cloth_gap},     {"scale", scale},
      {"far away", far_away},       {"triangles", triangles},
      {"texture", texture},         {"albedo", albedo},
      {"skin albedo", skin_albedo}, {"NaN texels", nan_texels}};
  const auto found = scenes.find(name);
  if (found == scenes.end()) {
    std::string known;
    for (const auto& [each, make] : scenes) known += (known.empty() ? "" : ", ") + each;
    throw InputError("", "scene '" + name + "'", "there is none of that name", "use one of: " + known);
  }
  return found->second(at);
}

}  // namespace ohb::studies
