#include "dataset/environments/room.h"

#include <algorithm>
#include <cmath>

#include "dataset/environments/landscape.h"
#include "dataset/model/sampling.h"

namespace ohb::environments {
namespace {

/// The two axes in a wall's plane.
void plane_axes(int axis, int& first, int& second) {
  first = axis == 0 ? 1 : 0;
  second = axis == 2 ? 1 : 2;
}

bool lies_in(const RoomRectangle& place, Vec3f point, int axis, bool is_far) {
  if (place.axis != axis || place.is_far != is_far) return false;
  int first, second;
  plane_axes(axis, first, second);
  return point[first] > place.low[0] && point[first] < place.high[0] && point[second] > place.low[1] &&
         point[second] < place.high[1];
}

bool is_bar(const RoomWindow& window, Vec3f point) {
  int axes[2];
  plane_axes(window.place.axis, axes[0], axes[1]);
  for (int k = 0; k < 2; ++k) {
    const float low = window.place.low[k], high = window.place.high[k], x = point[axes[k]];
    if (x - low < window.bar_width || high - x < window.bar_width) return true;
    const float pane = (high - low) / static_cast<float>(window.bars[k]), within = (x - low) / pane;
    if (std::fabs(within - std::round(within)) * pane < 0.5f * window.bar_width) return true;
  }
  return false;
}

void corners_of(const Room& room, const RoomRectangle& place, Vec3f (&corners)[4]) {
  int first, second;
  plane_axes(place.axis, first, second);
  for (int k = 0; k < 4; ++k) {
    corners[k][place.axis] = place.is_far ? room.size[place.axis] : 0;
    corners[k][first] = k == 1 || k == 2 ? place.high[0] : place.low[0];
    corners[k][second] = k >= 2 ? place.high[1] : place.low[1];
  }
}

float area_of(const RoomRectangle& place) {
  return (place.high[0] - place.low[0]) * (place.high[1] - place.low[1]);
}

/// Where the ray from inside leaves the room.
Vec3f leave(Vec3f size, Vec3f from, Vec3f way, int& axis, bool& is_far) {
  float nearest = 1e30f;
  for (int k = 0; k < 3; ++k) {
    if (std::fabs(way[k]) < 1e-7f) continue;
    const float t = ((way[k] > 0 ? size[k] : 0) - from[k]) / way[k];
    if (t < nearest) nearest = t, axis = k, is_far = way[k] > 0;
  }
  return from + way * nearest;
}

float luminance(Vec3f rgb) {
  return 0.2126f * rgb.x + 0.7152f * rgb.y + 0.0722f * rgb.z;
}

}  // namespace

float rectangle_irradiance(Vec3f point, Vec3f normal, const Vec3f (&corners)[4]) {
  float sum = 0;
  for (int k = 0; k < 4; ++k) {
    const Vec3f a = normalised(corners[k] - point), b = normalised(corners[(k + 1) % 4] - point);
    const Vec3f edge = cross(a, b);
    const float sine = length(edge);
    if (sine < 1e-7f) continue;
    sum += std::atan2(sine, dot(a, b)) * dot(edge, normal) / sine;
  }
  return 0.5f * std::fabs(sum);
}

RoomLight::RoomLight(const Room& room, RadianceOf outside) : room_(room), outside_(std::move(outside)) {
  const Vec3f s = room.size;
  const float surface = 2 * (s.x * s.y + s.x * s.z + s.y * s.z), ground = s.x * s.z;
  const Vec3f albedo =
      (room.floor + room.ceiling) * (ground / surface) + room.wall * (1 - 2 * ground / surface);
  Vec3f flux;  // that falls on the room's walls from outside and from the lamp
  for (const RoomWindow& window : room.windows) {
    Vec3f out, sum;
    out[window.place.axis] = window.place.is_far ? 1.0f : -1.0f;
    int first, second;
    plane_axes(window.place.axis, first, second);
    constexpr int kSide = 24;
    for (int i = 0; i < kSide; ++i)
      for (int j = 0; j < kSide; ++j) {  // even in the projected hemisphere
        const float radius = std::sqrt((static_cast<float>(i) + 0.5f) / kSide);
        const float phi = 2 * kPi * (static_cast<float>(j) + 0.5f) / kSide;
        Vec3f way = out * std::sqrt(1 - radius * radius);
        way[first] = radius * std::cos(phi), way[second] = radius * std::sin(phi);
        sum += outside_(to_world(way));
      }
    window_radiance_.push_back(sum / (kSide * kSide));
    flux += window_radiance_.back() * (kPi * area_of(window.place));
    const float facing = std::max(0.0f, dot(room.sun, out));
    flux += room.sun_irradiance * (facing * area_of(window.place) * 0.85f);  // without the bars
  }
  flux +=
      room.lamp.radiance * (4 * kPi * kPi * room.lamp.radius * room.lamp.radius);  // a ball's 4 pi r^2 x pi L
  // After the first bounce: flux x albedo, and each time albedo again (integrating sphere).
  for (int c = 0; c < 3; ++c) everywhere_[c] = flux[c] * albedo[c] / (surface * (1 - albedo[c]));
}

Vec3f RoomLight::to_room(Vec3f w) const {
  const float c = std::cos(room_.turn_rad), s = std::sin(room_.turn_rad);
  return {c * w.x - s * w.z, w.y, s * w.x + c * w.z};
}

Vec3f RoomLight::to_world(Vec3f r) const {
  const float c = std::cos(room_.turn_rad), s = std::sin(room_.turn_rad);
  return {c * r.x + s * r.z, r.y, c * r.z - s * r.x};
}

bool RoomLight::sees_sun(Vec3f point) const {
  int axis = 0;
  bool is_far = false;
  const Vec3f hit = leave(room_.size, point, room_.sun, axis, is_far);
  for (const RoomWindow& window : room_.windows)
    if (lies_in(window.place, hit, axis, is_far)) return !is_bar(window, hit);
  return false;
}

Vec3f RoomLight::wall_radiance(Vec3f point, int axis, bool is_far) const {
  Vec3f normal;
  normal[axis] = is_far ? -1.0f : 1.0f;
  Vec3f albedo = axis == 1 ? (is_far ? room_.ceiling : room_.floor) : room_.wall;
  for (const RoomPanel& panel : room_.panels)
    if (lies_in(panel.place, point, axis, is_far)) albedo = panel.albedo;
  if (axis == 1 && !is_far) albedo *= 0.85f + 0.3f * fractal_noise({point.x * 7, 0, point.z * 0.9f}, 3, 11);
  Vec3f light = everywhere_;
  const Vec3f inside = point + normal * 1e-3f;
  for (size_t k = 0; k < room_.windows.size(); ++k) {
    const RoomRectangle& place = room_.windows[k].place;
    if (place.axis == axis && place.is_far == is_far) continue;  // in the same plane
    Vec3f corners[4];
    corners_of(room_, place, corners);
    light += window_radiance_[k] * rectangle_irradiance(inside, normal, corners);
  }
  if (luminance(room_.lamp.radiance) > 0) {
    const Vec3f way = room_.lamp.place - inside;
    const float distance = length(way), cosine = std::max(0.0f, dot(way, normal) / distance);
    light +=
        room_.lamp.radiance * (kPi * room_.lamp.radius * room_.lamp.radius * cosine / (distance * distance));
  }
  const float facing = dot(room_.sun, normal);
  if (facing > 0 && luminance(room_.sun_irradiance) > 0 && sees_sun(inside))
    light += room_.sun_irradiance * facing;
  return albedo * light * kInvPi;
}

Vec3f RoomLight::radiance(Vec3f direction) const {
  const Vec3f way = to_room(direction);
  if (luminance(room_.lamp.radiance) > 0) {
    const Vec3f to_lamp = room_.lamp.place - room_.eye;
    const float along = dot(to_lamp, way);
    if (along > 0 && length(to_lamp - way * along) < room_.lamp.radius) return room_.lamp.radiance;
  }
  int axis = 0;
  bool is_far = false;
  const Vec3f point = leave(room_.size, room_.eye, way, axis, is_far);
  for (const RoomWindow& window : room_.windows)
    if (lies_in(window.place, point, axis, is_far))
      return is_bar(window, point) ? wall_radiance(point, axis, is_far) * 0.6f : outside_(direction);
  return wall_radiance(point, axis, is_far);
}

}  // namespace ohb::environments
