#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dataset/environments/area_lights.h"
#include "dataset/environments/landscape.h"
#include "dataset/environments/recipe_kinds.h"
#include "dataset/environments/room.h"
#include "dataset/environments/sky.h"

namespace ohb::environments {
namespace {

Vec3f paint_colour(Random& random) {
  // Mostly whites and greys, sometimes a colour.
  const float value = within(random, 0.35f, 0.8f);
  const float turns = random.next();
  const bool is_coloured = random.next() < 0.3f;
  const Vec3f hue = hue_of(turns, is_coloured ? within(random, 0.2f, 0.6f) : within(random, 0, 0.12f));
  Vec3f albedo = hue * value;
  const float most = std::max({albedo.x, albedo.y, albedo.z});
  return most > 0.85f ? albedo * (0.85f / most) : albedo;
}

/// On one of the four upright walls: `walls` counts them.
RoomRectangle upright(int wall, float middle, float half_width, float low, float high) {
  RoomRectangle place;
  place.axis = wall % 2 == 0 ? 2 : 0, place.is_far = wall < 2;
  // In a wall across x the plane's axes are y, z; in one across z they are x, y.
  const int along = place.axis == 0 ? 1 : 0;
  place.low[along] = middle - half_width, place.high[along] = middle + half_width;
  place.low[1 - along] = low, place.high[1 - along] = high;
  return place;
}

void add_windows(Random& random, int wall, Room& room) {
  const float length = wall % 2 == 0 ? room.size.x : room.size.z;
  const int count = 1 + below(random, length > 5 ? 3 : 2);
  const float sill = random.next() < 0.3f ? 0.05f : within(random, 0.6f, 1.0f);
  const float top = std::min(room.size.y - 0.15f, sill + within(random, 1.1f, 2.3f));
  const float half = length / static_cast<float>(count) * within(random, 0.22f, 0.42f);
  const int bars[2] = {1 + below(random, 3), 1 + below(random, 3)};
  for (int k = 0; k < count; ++k) {
    RoomWindow window;
    window.place =
        upright(wall, length * (static_cast<float>(k) + 0.5f) / static_cast<float>(count), half, sill, top);
    window.bars[0] = bars[0], window.bars[1] = bars[1];
    window.bar_width = 0.05f;
    room.windows.push_back(window);
  }
}

void add_panels(Random& random, int wall, Room& room) {
  const float length = wall % 2 == 0 ? room.size.x : room.size.z;
  if (random.next() < 0.5f) {  // a door
    room.panels.push_back(
        {upright(wall, within(random, 0.8f, length - 0.8f), 0.45f, 0, 2.05f), paint_colour(random) * 0.7f});
    return;
  }
  const int pictures = 1 + below(random, 3);
  for (int k = 0; k < pictures; ++k) {
    const float middle = length * (static_cast<float>(k) + 0.5f) / static_cast<float>(pictures);
    const float half_width = within(random, 0.2f, 0.4f), top = within(random, 1.6f, 2.1f);
    const float hue = random.next(), saturation = within(random, 0.1f, 0.7f);
    const Vec3f albedo = hue_of(hue, saturation) * within(random, 0.05f, 0.35f);
    room.panels.push_back({upright(wall, middle, half_width, 1.2f, top), albedo});
  }
}

Room draw_room(Random& random, std::string& words) {
  Room room;
  room.size = {within(random, 3.5f, 8), within(random, 2.4f, 3.4f), within(random, 3.5f, 9)};
  room.eye = {room.size.x * within(random, 0.3f, 0.7f), within(random, 1.0f, 1.6f),
              room.size.z * within(random, 0.3f, 0.7f)};
  room.turn_rad = within(random, -kPi, kPi);
  room.wall = paint_colour(random);
  room.ceiling = Vec3f{0.78f, 0.78f, 0.76f} * within(random, 0.8f, 1);
  constexpr Vec3f kFloors[] = {
      {0.30f, 0.18f, 0.10f}, {0.42f, 0.30f, 0.18f}, {0.25f, 0.25f, 0.26f}, {0.45f, 0.42f, 0.38f}};
  const Vec3f floor = kFloors[below(random, 4)];
  room.floor = floor * within(random, 0.7f, 1.3f);
  const int first = below(random, 4), window_walls = 1 + below(random, 2);
  for (int wall = 0; wall < 4; ++wall) {
    if (wall == first || (window_walls == 2 && wall == (first + 1) % 4))
      add_windows(random, wall, room);
    else
      add_panels(random, wall, room);
  }
  words = fmt::format("room of {:.1f} x {:.1f} x {:.1f} m, {} windows", room.size.x, room.size.z, room.size.y,
                      room.windows.size());
  return room;
}

}  // namespace

Painting room_with_windows(Random& random, int width_px) {
  std::string words;
  Room room = draw_room(random, words);
  const bool is_sunny = random.next() < 0.5f;
  const float azimuth = within(random, -180, 180), elevation = within(random, 8, 50),
              turbidity = within(random, 2, 5);
  const Vec3f sun = towards_degrees({azimuth, elevation});
  const ClearSky clear(sun, turbidity);
  const Vec3f grey = light_of_temperature(6800) * within(random, 4, 9);
  const Landscape land = draw_landscape(random);
  const RadianceOf sky = [&](Vec3f way) {
    return is_sunny ? clear.radiance(way) : grey * overcast_share(way);
  };
  if (is_sunny) {
    room.sun_irradiance = sun_irradiance(sun.y, turbidity);
    // The room is turned: its sun turns with it.
    const float c = std::cos(room.turn_rad), s = std::sin(room.turn_rad);
    room.sun = {c * sun.x - s * sun.z, sun.y, s * sun.x + c * sun.z};
  }
  if (random.next() < 0.35f) {
    room.lamp.place = {room.size.x * within(random, 0.3f, 0.7f), room.size.y - within(random, 0.25f, 0.7f),
                       room.size.z * within(random, 0.3f, 0.7f)};
    room.lamp.radius = within(random, 0.08f, 0.2f);
    const Vec3f white = light_of_temperature(within(random, 2600, 4000));
    room.lamp.radiance = white * within(random, 3, 25);
    words += ", lamp";
  }
  const Vec3f on_ground = irradiance_from_above(sky) + room.sun_irradiance * sun.y;
  const Vec3f haze = sky(normalised({1, 0.05f, 1}));
  const RoomLight light(room, [&](Vec3f way) {
    Vec3f radiance;
    return sees_landscape(land, way, on_ground, haze, radiance) ? radiance : sky(way);
  });
  Image map = painted(width_px, kPaintSamples, [&](Vec3f way) { return light.radiance(way); });
  return {std::move(map), words + (is_sunny ? ", sun" : ", overcast")};
}

}  // namespace ohb::environments
