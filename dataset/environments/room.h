// A box room with windows, seen from inside: walls are lit by the windows, the sun that falls through them
// and a lamp, once; what bounces further is the same everywhere.
#pragma once

#include <functional>
#include <vector>

#include "dataset/environments/painting.h"
#include "dataset/model/vec.h"

namespace ohb::environments {

/// Lengths in m; the room spans [0, size] and the eye stands inside it.
struct RoomRectangle {
  int axis = 0;        // of the wall's normal: 0 x, 1 y, 2 z
  bool is_far = true;  // on the wall at size[axis], not on that at 0
  // In the wall's plane: along the other two axes, in the order x, y, z.
  float low[2] = {}, high[2] = {};
};

struct RoomWindow {
  RoomRectangle place;
  int bars[2] = {1, 1};  // panes along each side
  float bar_width = .04f;
};

struct RoomPanel {  // a door, a picture, a carpet
  RoomRectangle place;
  Vec3f albedo;
};

struct RoomLamp {
  Vec3f place;  // on the ceiling, or hanging
  float radius = 0.2f;
  Vec3f radiance;  // 0: none
};

struct Room {
  Vec3f size{5, 2.7f, 6}, eye{2.5f, 1.4f, 3};
  float turn_rad = 0;          // of the room about the vertical
  Vec3f wall, floor, ceiling;  // albedo
  std::vector<RoomWindow> windows;
  std::vector<RoomPanel> panels;
  RoomLamp lamp;
  Vec3f sun;             // unit direction in the room's axes; irradiance 0: none
  Vec3f sun_irradiance;  // of a plane that faces it
};

/// Irradiance at a point from a rectangle of even radiance 1, which must lie wholly before the plane of
/// `normal` (Lambert 1760: half the sum over the edges of angle x cosine to the edge's plane).
float rectangle_irradiance(Vec3f point, Vec3f normal, const Vec3f (&corners)[4]);

/// Radiance as the eye sees it. `outside` is what is seen through the windows, in the world's axes.
class RoomLight {
 public:
  RoomLight(const Room& room, RadianceOf outside);
  Vec3f radiance(Vec3f direction) const;

 private:
  Vec3f wall_radiance(Vec3f point, int axis, bool is_far) const;
  bool sees_sun(Vec3f point) const;
  Vec3f to_room(Vec3f world) const;
  Vec3f to_world(Vec3f room) const;

  Room room_;
  RadianceOf outside_;
  std::vector<Vec3f> window_radiance_;  // mean, towards the room
  Vec3f everywhere_;                    // irradiance of all further bounces
};

}  // namespace ohb::environments
