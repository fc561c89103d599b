#include <fmt/format.h>

#include <cmath>

#include "dataset/environments/area_lights.h"
#include "dataset/environments/landscape.h"
#include "dataset/environments/recipe_kinds.h"
#include "dataset/environments/sky.h"
#include "dataset/model/noise.h"

namespace ohb::environments {
namespace {

struct Sun {
  float azimuth_deg, elevation_deg;
  Vec3f way() const { return towards_degrees({azimuth_deg, elevation_deg}); }
};

Sun draw_sun(Random& random, float lowest_deg, float highest_deg) {
  const float azimuth = within(random, -180, 180);
  return {azimuth, within(random, lowest_deg, highest_deg)};
}

std::string sun_words(const Sun& sun) {
  return fmt::format("sun {:.0f} degrees up at azimuth {:.0f}", sun.elevation_deg, sun.azimuth_deg);
}

/// Above the landscape `sky`, a sun (irradiance 0: none), all in kcd/m2 and klx.
Image outdoors(int width_px, const Landscape& land, const RadianceOf& sky, Vec3f sun, Vec3f sun_light) {
  const Vec3f on_ground = irradiance_from_above(sky) + sun_light * std::max(0.0f, sun.y);
  Vec3f haze;  // the mean of the sky just above the horizon
  for (int k = 0; k < 64; ++k) {
    const float phi = 2 * kPi * static_cast<float>(k) / 64;
    haze += sky(normalised({std::cos(phi), 0.05f, std::sin(phi)})) / 64;
  }
  Image map = painted(width_px, kPaintSamples, [&](Vec3f way) {
    Vec3f radiance;
    return sees_landscape(land, way, on_ground, haze, radiance) ? radiance : sky(way);
  });
  if (dot(sun_light, {1, 1, 1}) > 0) {
    Vec3f hidden;
    if (!sees_landscape(land, sun, on_ground, haze, hidden)) add_disc(map, sun, kSunRadius_rad, sun_light);
  }
  return map;
}

/// Cloud cover on a plane, 0 to 1, thinning out towards the horizon.
float cloud_at(Vec3f way, float cover, float size, uint64_t pattern) {
  if (way.y < 0.02f) return 0;
  const float reach = size / (way.y + 0.12f);
  const float noise = fractal_noise({way.x * reach, 0, way.z * reach}, 6, pattern);
  return smooth(0.62f - 0.3f * cover, 0.78f - 0.3f * cover, noise) * smooth(0.02f, 0.12f, way.y);
}

/// Light of clouds: thick ones are darker below, thin ones glow about the sun.
Vec3f cloud_light(Vec3f way, Vec3f sun, Vec3f sun_light, Vec3f ambient, float cover) {
  const float forward = std::exp(6 * (dot(way, sun) - 1));
  const float bright = 0.35f - 0.2f * cover + 0.5f * forward;
  return sun_light * (bright * kInvPi * 0.9f) + ambient * 0.9f;
}

Painting with_clouds(Random& random, int width_px, const Sun& sun, float turbidity, float cover,
                     const char* what) {
  const ClearSky clear(sun.way(), turbidity);
  const Vec3f way_to_sun = sun.way(), light = sun_irradiance(way_to_sun.y, turbidity);
  const Landscape land = draw_landscape(random);
  const float size = within(random, 0.8f, 2);
  const uint64_t pattern = random.next_bits();
  const Vec3f ambient = irradiance_from_above([&](Vec3f way) { return clear.radiance(way); }) * kInvPi;
  const RadianceOf sky = [&](Vec3f way) {
    const float cloud = cloud_at(way, cover, size, pattern);
    const Vec3f blue = clear.radiance(way);
    return cloud <= 0 ? blue
                      : blue * (1 - cloud) + cloud_light(way, way_to_sun, light, ambient, cloud) * cloud;
  };
  // What the clouds leave of the sun (Beer's law of a thick one is 2 %).
  const float left = std::pow(0.02f, cloud_at(way_to_sun, cover, size, pattern));
  Image map = outdoors(width_px, land, sky, way_to_sun, light * left);
  return {std::move(map), fmt::format("{}, turbidity {:.1f}, {}, clouds {:.2f}, {}", what, turbidity,
                                      sun_words(sun), cover, land.words())};
}

}  // namespace

Painting clear_sky(Random& random, int width_px) {
  const Sun sun = draw_sun(random, 15, 70);
  const float turbidity = within(random, 2, 6);
  const ClearSky sky(sun.way(), turbidity);
  const Landscape land = draw_landscape(random);
  Image map = outdoors(
      width_px, land, [&](Vec3f way) { return sky.radiance(way); }, sun.way(),
      sun_irradiance(sun.way().y, turbidity));
  return {std::move(map),
          fmt::format("clear sky, turbidity {:.1f}, {}, {}", turbidity, sun_words(sun), land.words())};
}

Painting cloudy_sky(Random& random, int width_px) {
  const Sun sun = draw_sun(random, 15, 65);
  const float turbidity = within(random, 2, 5);
  return with_clouds(random, width_px, sun, turbidity, within(random, 0.25f, 0.85f), "clouds");
}

Painting sunset(Random& random, int width_px) {
  const Sun sun = draw_sun(random, 3, 10);
  const float turbidity = within(random, 2.5f, 6);
  return with_clouds(random, width_px, sun, turbidity, within(random, 0, 0.6f), "sunset");
}

Painting overcast(Random& random, int width_px) {
  const Landscape land = draw_landscape(random);
  const Vec3f white = light_of_temperature(within(random, 5800, 8000));
  const float contrast = within(random, 0.05f, 0.4f), glow = within(random, 0, 1.5f);
  const Sun sun = draw_sun(random, 20, 60);
  const uint64_t pattern = random.next_bits();
  const float zenith_kcd = within(random, 3, 12);
  const RadianceOf sky = [&](Vec3f way) {
    const float reach = 1 / (std::max(way.y, 0.0f) + 0.25f);
    const float mottled = fractal_noise({way.x * reach, 7, way.z * reach}, 5, pattern) - 0.5f;
    const float behind = glow * std::exp(7 * (dot(way, sun.way()) - 1));
    return white * (zenith_kcd * overcast_share(way) * (1 + 2 * contrast * mottled) * (1 + behind));
  };
  Image map = outdoors(width_px, land, sky, {0, 1, 0}, {});
  return {std::move(map),
          fmt::format("overcast, glow {:.1f} about {}, {}", glow, sun_words(sun), land.words())};
}

}  // namespace ohb::environments
