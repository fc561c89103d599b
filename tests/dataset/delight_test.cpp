// A picture that is a known albedo times the light of its surroundings, as our own path tracer computes it,
// gives the albedo back; one without such light is left alone.
#include "dataset/commands/delight.h"

#include <gtest/gtest.h>

#include <cmath>

#include "bake/ambient_light.h"
#include "dataset/model/camera.h"
#include "renderer/render.h"
#include "tests/bake/test_scans.h"
#include "tests/support/scan_files.h"
#include "tests/support/test_files.h"
#include "tests/support/test_models.h"

namespace ohb {
using namespace bake;
using namespace commands;
using namespace renderer;
using namespace surface;
namespace {

constexpr int kPicture_px = 96;
constexpr float kEdge_cm = 60;

Vec3f albedo_at(Vec2f uv) {
  const float waves = 0.1f * std::sin(19 * uv.x) * std::sin(13 * uv.y);
  return {0.4f + waves, 0.3f + 0.5f * waves + 0.1f * uv.x, 0.25f};
}

Image albedo_picture() {
  Image image(kPicture_px, kPicture_px, 3);
  for (int y = 0; y < kPicture_px; ++y)
    for (int x = 0; x < kPicture_px; ++x) {
      const Vec3f c = albedo_at(
          {(static_cast<float>(x) + 0.5f) / kPicture_px, 1 - (static_cast<float>(y) + 0.5f) / kPicture_px});
      for (int k = 0; k < 3; ++k) image.pixel(x, y)[k] = c[k];
    }
  return image;
}

/// Bumps and pits, seen from +Z without hiding one another; UVs are the places in the camera's picture.
struct Bumps {
  Model model;
  Camera camera;
  Bumps() {
    TextureSet set = constant_set({{1, 1, 1}, 1, 0, 0}, kPicture_px);
    set.albedo = albedo_picture();
    model = grid_model(
        160, 160,
        [](float u, float v) {
          const float z =
              2.5f * std::sin(21 * u) * std::cos(17 * v) + std::sin(50 * u + 3) * std::sin(44 * v);
          return Vec3f{(u - 0.5f) * kEdge_cm, v * kEdge_cm, z};
        },
        set);
    camera = fit_camera(model.positions_cm);
    for (size_t p = 0; p < model.positions_cm.size(); ++p) {
      const Vec3f at = model.positions_cm[p];
      const float scale = 0.5f / (camera.half_width * (camera.distance_cm - at.z));
      model.uvs[p] = {0.5f + at.x * scale, 0.5f + (at.y - camera.center_y_cm) * scale};
    }
  }
  /// What the camera sees in that light, not premultiplied: the texels of its UVs.
  Image seen_in(const Image& light, int spp) const {
    Environment environment;
    environment.radiance = light;
    RenderSettings settings;
    settings.size_px = kPicture_px;
    settings.spp = spp;
    settings.shading = ShadingModel::kV2;  // Lambert
    const auto scene = build_scene(model);
    const auto lights = prepare_lights({environment}, {});
    Image seen = render_lights({*scene, *lights, camera, 0}, settings)[0].radiance;
    const Image mask = render_maps(*scene, camera, 0, settings).mask;
    for (size_t i = 0; i < seen.values.size(); ++i)
      if (mask.values[i / 3] > 0) seen.values[i] /= mask.values[i / 3];
    return seen;
  }
};

/// Root mean square over the texels 4 px inside the sheet of the relative error against the albedo, each
/// picture scaled to its mean: exposure is nobody's business.
double error_of(const Image& picture, const Bumps& bumps) {
  const Image truth = albedo_picture();
  float low = 1;
  for (const Vec2f uv : bumps.model.uvs) low = std::min(low, std::min(uv.x, uv.y));
  const int margin = static_cast<int>(low * kPicture_px) + 4;
  double ratio = 0, count = 0, squares = 0;
  for (int pass = 0; pass < 2; ++pass)
    for (int y = margin; y < kPicture_px - margin; ++y)
      for (int x = margin; x < kPicture_px - margin; ++x)
        for (int c = 0; c < 3; ++c) {
          const double here = picture.pixel(x, y)[c] / truth.pixel(x, y)[c];
          if (pass == 0) {
            ratio += here;
            ++count;
          } else {
            squares += std::pow(here / (ratio / count) - 1, 2);
          }
        }
  return std::sqrt(squares / count);
}

/// The figures of docs/measurements/bake.md are in the test's XML report.
struct Delit {
  DelightReport report;
  double before, after;
};

Delit delight_of(const Bumps& bumps, const Image& picture) {
  const TemporaryFolder folder;
  write_exr(folder / "p.exr", {{"p", {"R", "G", "B"}, ExrPart::Type::kFloat, picture}}, {});
  Scan scan = scan_of_model(bumps.model, "bumps.obj");
  scan.materials[0].diffuse = {folder / "p.exr", nullptr};
  const Regions regions{std::vector<uint8_t>(scan.face_count(), kSkin), std::string(64, '0')};
  Delit result{delight(scan, bake::canonical_mesh(scan, regions, 1), folder.path()), error_of(picture, bumps),
               0};
  result.after = error_of(read_image(scan.materials[0].diffuse), bumps);
  testing::Test::RecordProperty("error_before", std::to_string(result.before));
  testing::Test::RecordProperty("error_after", std::to_string(result.after));
  testing::Test::RecordProperty("slope", std::to_string(result.report.regions.at(0).slope));
  return result;
}

TEST(Delight, GivesTheAlbedoBackOfATextureInAmbientLight) {
  const Bumps bumps;
  const Delit delit = delight_of(bumps, bumps.seen_in(constant_radiance({1, 1, 1}), 256));
  ASSERT_EQ(delit.report.regions.size(), 1u);
  EXPECT_TRUE(delit.report.regions[0].is_delit);
  EXPECT_NEAR(delit.report.regions[0].slope, 1, 0.3);
  EXPECT_GT(delit.before, 0.08);
  EXPECT_LT(delit.after, delit.before / 3);
  EXPECT_TRUE(warnings_of(delit.report).empty());
}

TEST(Delight, LeavesATextureWithoutShadingAlone) {
  const Bumps bumps;
  const Delit delit = delight_of(bumps, albedo_picture());
  EXPECT_FALSE(delit.report.regions[0].is_delit);
  EXPECT_LT(delit.after, 1e-3) << "half precision";
  ASSERT_EQ(warnings_of(delit.report).size(), 1u);
  expect_message(warnings_of(delit.report)[0], {"skin", "nothing to delight"});
}

/// A lamp at one side is not ambient light: what is left is said in docs/commands/bake.md.
TEST(Delight, DoesNotMendDirectionalLight) {
  const Bumps bumps;
  Image lamp = constant_radiance({0.2f, 0.2f, 0.2f}, 16);
  for (int y = 4; y < 6; ++y)
    for (int x = 26; x < 29; ++x)
      for (int c = 0; c < 3; ++c) lamp.pixel(x, y)[c] = 30;
  const Delit delit = delight_of(bumps, bumps.seen_in(lamp, 64));
  EXPECT_GT(delit.after, 0.6 * delit.before);
  EXPECT_LT(delit.after, 1.3 * delit.before);
}

TEST(AmbientLight, OfAnOpenPlaneAndInsideABall) {
  const Model plane = plane_model(100, constant_set({}));
  const std::vector<uint8_t> all(plane.triangles.size(), 1);
  for (const Vec3f e : ambient_irradiance(plane, all, std::vector<Vec3f>(4), 64)) EXPECT_EQ(e.x, 1);
  // From inside a closed ball nothing but the glow is seen.
  Model ball = sphere_model(50, 32, constant_set({}));
  for (ModelTriangle& triangle : ball.triangles) std::swap(triangle.position[1], triangle.position[2]);
  const std::vector<Vec3f> glow(ball.positions_cm.size(), {0.5f, 0.25f, 0});
  const auto inside = ambient_irradiance(ball, std::vector<uint8_t>(ball.triangles.size(), 1), glow, 64);
  EXPECT_NEAR(inside[32 * 5].x, 0.5f, 1e-5f);
  EXPECT_NEAR(inside[32 * 5].y, 0.25f, 1e-5f);
}

/// A wall that meets the floor at a right angle hides half of the floor's light at the edge: E = (1 + cos a)
/// / 2 at a distance d from an endless wall of height h, tan a = h / d.
TEST(AmbientLight, BesideAWall) {
  Model model = grid_model(
      2, 40,
      [](float u, float v) {
        return Vec3f{(u - 0.5f) * 8000, 0, 100 * v};
      },
      constant_set({}));
  const size_t floor_count = model.positions_cm.size();
  Model wall = grid_model(
      2, 2,
      [](float u, float v) {
        return Vec3f{(u - 0.5f) * 8000, 50 * v, 0};
      },
      constant_set({}));
  for (const Vec3f p : wall.positions_cm) model.positions_cm.push_back(p);
  for (ModelTriangle t : wall.triangles) {
    for (uint32_t& p : t.position) p += static_cast<uint32_t>(floor_count);
    model.triangles.push_back(t);
  }
  // The floor's normal is -Y as made: turn it up.
  for (size_t t = 0; t + wall.triangles.size() < model.triangles.size(); ++t)
    std::swap(model.triangles[t].position[1], model.triangles[t].position[2]);
  const auto e = ambient_irradiance(model, std::vector<uint8_t>(model.triangles.size(), 1),
                                    std::vector<Vec3f>(model.positions_cm.size()), 4096);
  for (const int row : {4, 10, 20, 40}) {
    const double d = 2.5 * row, expected = 0.5 * (1 + d / std::hypot(d, 50));
    EXPECT_NEAR(e[static_cast<size_t>(3 * row + 1)].x, expected, 0.005) << d;
  }
}

}  // namespace
}  // namespace ohb
