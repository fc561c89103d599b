// What is computed against closed forms.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

#include "dataset/environments/area_lights.h"
#include "dataset/environments/landscape.h"
#include "dataset/environments/painting.h"
#include "dataset/environments/primaries.h"
#include "dataset/environments/recipe.h"
#include "dataset/environments/room.h"
#include "dataset/environments/sky.h"
#include "dataset/environments/sphere_map.h"
#include "dataset/model/environment.h"
#include "dataset/model/sampling.h"

namespace ohb::environments {
namespace {

constexpr double kPiDouble = 3.14159265358979323846;

Image random_map(int width_px, int height_px) {
  Image map(width_px, height_px, 3);
  Random random(3, 5, 7);
  for (float& value : map.values) value = random.next() * (random.next() < 0.01f ? 3000 : 1);
  return map;
}

TEST(SphereMap, TexelsMakeTheWholeSphere) {
  double sum = 0;
  for (int y = 0; y < 37; ++y) sum += 74 * texel_solid_angle(y, 74, 37);
  EXPECT_NEAR(sum, 4 * kPiDouble, 1e-12);
}

TEST(SphereMap, ResamplingKeepsTheEnergyOfEachChannel) {
  const Image map = random_map(362, 181);
  const std::array<double, 3> before = energy_of(map);
  for (const int width : {2, 64, 100, 362, 512, 1000}) {
    const std::array<double, 3> after = energy_of(resampled(map, width));
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(after[c] / before[c], 1, 1e-6) << width;
  }
}

TEST(SphereMap, ResamplingKeepsDirections) {
  Image map(512, 256, 3);
  for (int c = 0; c < 3; ++c) map.pixel(100, 60)[c] = 5000;
  const Vec3f before = statistics_of(map).brightest, after = statistics_of(resampled(map, 96)).brightest;
  EXPECT_GT(dot(before, after), std::cos(1.5 * kPiDouble / 48));
}

TEST(Painting, EvenLightStaysEven) {
  const Image map = painted(64, 2, [](Vec3f) { return Vec3f{1, 2, 3}; });
  for (size_t i = 0; i < map.values.size(); ++i)
    EXPECT_FLOAT_EQ(map.values[i], static_cast<float>(1 + i % 3));
}

TEST(Painting, TexelsLieWhereEnvironmentDirectionsPoint) {
  const Image map = painted(64, 1, [](Vec3f way) { return Vec3f{way.x + 1, way.y + 1, way.z + 1}; });
  for (const int y : {3, 16, 30})
    for (const int x : {0, 20, 63}) {
      const Vec3f way = environment_direction({(x + 0.5f) / 64, (y + 0.5f) / 32});
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(map.pixel(x, y)[c], way[c] + 1, 0.01f);  // a tenth of a texel
    }
}

TEST(Painting, TheSunsEnergyIsExactWhateverTheTexels) {
  const Vec3f light{90, 80, 60};
  for (const int width : {16, 200, 1024, 4096})
    for (const Vec3f sun : {normalised({0.3f, 0.4f, 0.8f}), normalised({-1, 0.02f, 0}), Vec3f{0, 1, 0}}) {
      Image map(width, width / 2, 3);
      add_disc(map, sun, kSunRadius_rad, light);
      const std::array<double, 3> energy = energy_of(map);
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(energy[static_cast<size_t>(c)] / static_cast<double>(light[c]), 1, 1e-5) << width;
      EXPECT_GT(dot(statistics_of(map).brightest, sun), std::cos(2 * kPiDouble / width + 0.005)) << width;
    }
}

TEST(Painting, AnyNumberOfThreadsGivesTheSameBits) {
  for (const uint64_t index : {0, 1, 2, 4}) {
    const Image many = synthesised(5, index, 64).radiance;
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    EXPECT_EQ(synthesised(5, index, 64).radiance.values, many.values) << index;
  }
}

TEST(AreaLights, EnergyIsRadianceTimesSolidAngle) {
  AreaLight light;
  light.towards = normalised({0.5f, 0.3f, 0.9f});
  light.roll_rad = 0.2f;
  light.half_width = 0.4f, light.half_height = 0.25f;
  light.radiance = {2, 3, 4};
  for (const auto shape : {AreaLight::Shape::kRectangle, AreaLight::Shape::kDisc, AreaLight::Shape::kRing}) {
    light.shape = shape;
    const Image map = painted(512, 2, [&](Vec3f way) {
      Vec3f radiance;
      return shines(light, way, radiance) ? radiance : Vec3f{};
    });
    const std::array<double, 3> energy = energy_of(map);
    for (size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(energy[c] / ((2 + static_cast<double>(c)) * solid_angle_of(light)), 1, 2e-3);
  }
}

TEST(Sky, OvercastLightsTheGroundByTheClosedForm) {
  const Vec3f light = irradiance_from_above([](Vec3f way) { return Vec3f{1, 1, 1} * overcast_share(way); });
  EXPECT_NEAR(light.x, 7 * kPiDouble / 9, 2e-3);
}

// Values of the paper's formulas, worked out apart from this code: turbidity 3, sun at 45 degrees.
TEST(Sky, PreethamsZenith) {
  const Vec3f sun = normalised({0, 1, 1});
  const ClearSky sky(sun, 3);
  const Vec3f zenith = sky.radiance({0, 1, 0});
  // Yz = (4.0453 x 3 - 4.9710) tan((4/9 - 3/120) pi/2) - 0.2155 x 3 + 2.4192 = 7.2649 x 0.7751 + 1.7727
  EXPECT_NEAR(0.2126f * zenith.x + 0.7152f * zenith.y + 0.0722f * zenith.z, 7.327f, 0.03f);
  EXPECT_GT(zenith.z, zenith.y);
  EXPECT_GT(zenith.y, zenith.x);
  const auto luminance = [&](Vec3f way) { return sky.radiance(normalised(way)).y; };
  EXPECT_GT(luminance({0, 1, 1.2f}), luminance({0, 1, -1.2f}));  // brighter about the sun
}

TEST(Sky, TheSunReddensAsItSets) {
  const Vec3f high = sun_irradiance(1, 3), low = sun_irradiance(0.1f, 3);
  EXPECT_GT(high.y, 85);  // about 100 klx reach the ground
  EXPECT_LT(high.y, 110);
  EXPECT_LT(low.y, 0.3f * high.y);
  EXPECT_GT(low.x / low.z, 3 * high.x / high.z);
}

TEST(Room, RectangleIrradianceIsTheFormFactorOfTextbooks) {
  // A square of side 2 at distance 1, before a point facing its middle: F = 4 x (corner factor) with
  // a = b = 1: (1 / 2 pi) (2 x 1/sqrt 2 x atan(1/sqrt 2)); irradiance = pi F.
  const Vec3f corners[4] = {{-1, -1, 1}, {1, -1, 1}, {1, 1, 1}, {-1, 1, 1}};
  const double corner = 2 / std::sqrt(2.0) * std::atan(1 / std::sqrt(2.0)) / (2 * kPiDouble);
  EXPECT_NEAR(rectangle_irradiance({0, 0, 0}, {0, 0, 1}, corners), kPiDouble * 4 * corner, 1e-5);
}

TEST(Room, AClosedWhiteWallSeesWhatAnIntegratingSphereSays) {
  // A cube with one wall a window of radiance 1: the mean light of the others lies near the closed form.
  Room room;
  room.size = {2, 2, 2}, room.eye = {1, 1, 1};
  room.wall = room.floor = room.ceiling = {0.5f, 0.5f, 0.5f};
  RoomWindow window;
  window.place.axis = 2, window.place.is_far = true;
  window.place.high[0] = window.place.high[1] = 2;
  window.bar_width = 0;
  room.windows.push_back(window);
  const RoomLight light(room, [](Vec3f) { return Vec3f{1, 1, 1}; });
  // The wall across: form factor 0.19982 of two faces of a cube; further bounces flux x albedo / (A (1 -
  // albedo)).
  double sum = 0;
  const int side = 40;
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j) {
      const Vec3f point{2 * (i + 0.5f) / side, 2 * (j + 0.5f) / side, 0};
      sum += static_cast<double>(light.radiance(normalised(point - room.eye)).x);
    }
  const double everywhere = kPiDouble * 4 * 0.5 / (24 * 0.5);
  EXPECT_NEAR(sum / (side * side), 0.5 / kPiDouble * (kPiDouble * 0.19982 + everywhere), 2e-3);
}

TEST(Primaries, AcesWhiteStaysWhite) {
  const Chromaticities aces_cg = {0.713, 0.293, 0.165, 0.830, 0.128, 0.044, 0.32168, 0.33767};
  const std::array<double, 9> matrix = to_rec709(aces_cg);
  for (size_t i = 0; i < 3; ++i) EXPECT_NEAR(matrix[3 * i] + matrix[3 * i + 1] + matrix[3 * i + 2], 1, 1e-3);
  EXPECT_NEAR(matrix[0], 1.705, 2e-3);  // the published AP1 to Rec. 709 (Bradford)
  EXPECT_NEAR(matrix[1], -0.622, 2e-3);
  const std::array<double, 9> same = to_rec709(kRec709);
  for (size_t i = 0; i < 9; ++i) EXPECT_NEAR(same[i], i % 4 == 0, 1e-9);
}

TEST(Recipe, SharesOfTheCategoriesAreFixed) {
  int rooms = 0, studios = 0, sunsets = 0;
  for (uint64_t k = 0; k < 310; ++k) {
    rooms += category_of(k) == "room", studios += category_of(k) == "studio",
        sunsets += category_of(k) == "sunset";
  }
  EXPECT_EQ(rooms, 62);
  EXPECT_EQ(studios, 62);
  EXPECT_EQ(sunsets, 31);
}

TEST(Recipe, EveryKindIsFiniteLitAndUnlikeItsSiblings) {
  for (uint64_t k = 0; k < 20; ++k) {
    const SynthesisedLight light = synthesised(1, k, 64);
    for (const float value : light.radiance.values)
      ASSERT_TRUE(std::isfinite(value) && value >= 0) << light.words;
    const LightStatistics statistics = statistics_of(light.radiance);
    const double mean =
        0.2126 * statistics.mean[0] + 0.7152 * statistics.mean[1] + 0.0722 * statistics.mean[2];
    EXPECT_GT(mean, 0.34);
    EXPECT_LT(mean, 1.21);
    EXPECT_NE(light.radiance.values, synthesised(2, k, 64).radiance.values);
    EXPECT_NE(light.radiance.values, synthesised(1, k + 10, 64).radiance.values);
  }
}

}  // namespace
}  // namespace ohb::environments
