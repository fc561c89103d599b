// No pixel that sees something is left out.
#include "renderer/footprint.h"

#include <gtest/gtest.h>

#include "tests/support/test_models.h"

namespace ohb {
using namespace renderer;
using namespace surface;
namespace {

TEST(Footprint, HoldsEveryPixelWhoseRaysHit) {
  constexpr int kSize = 96;
  Model model = sphere_model(20, 24, constant_set({}));
  for (Vec3f& p : model.positions_cm) p = p + std::sin(p.y) * Vec3f{3, 0, 1};
  const auto scene = build_scene(model);
  Random random(5, 5, 5);
  size_t left_out = 0;
  for (int view_number = 0; view_number < 8; ++view_number) {
    const ViewCamera view(fit_camera(model.positions_cm), view_number, kSize);
    const std::vector<uint8_t> seen = footprint(*scene, view, kSize);
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x) {
        if (seen[static_cast<size_t>(y) * kSize + x]) continue;
        ++left_out;
        for (int k = 0; k < 32; ++k) {
          const float u = random.next(), v = random.next();
          RayCounts counts;
          Hit hit;
          ASSERT_FALSE(intersect<false>(
              *scene, view.ray(static_cast<float>(x) + u, static_cast<float>(y) + v), random, counts, hit))
              << x << " " << y << " view " << view_number;
        }
      }
  }
  EXPECT_GT(left_out, 8 * kSize * kSize / 4) << "most of the background is left out";
}

TEST(Footprint, ProjectionIsTheInverseOfTheCamerasRays) {
  Camera camera;
  camera.center_y_cm = 90;
  camera.distance_cm = 400;
  camera.half_width = 0.2f;
  const ViewCamera view(camera, 0.7, 128);
  Vec2f image;
  for (const Vec2f at : {Vec2f{0, 0}, Vec2f{64, 64}, Vec2f{127.5f, 3.25f}}) {
    const Ray ray = view.ray(at.x, at.y);
    ASSERT_TRUE(view.project(ray.origin + 350 * ray.direction, image));
    EXPECT_NEAR(image.x, at.x, 1e-3);
    EXPECT_NEAR(image.y, at.y, 1e-3);
    EXPECT_FALSE(view.project(ray.origin - 350 * ray.direction, image));
  }
}

TEST(Footprint, InsideTheMeshEverythingIsSeen) {
  const auto scene = build_scene(sphere_model(50, 16, constant_set({})));
  Camera camera;
  camera.center_y_cm = 50;
  camera.distance_cm = 0;
  camera.half_width = 0.2f;
  for (const uint8_t seen : footprint(*scene, ViewCamera(camera, 0, 16), 16)) ASSERT_EQ(seen, 1);
}

}  // namespace
}  // namespace ohb
