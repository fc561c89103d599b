// Small vectors. Plain structs so that hot code, files and Embree share one layout.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace ohb {

struct Vec2f {
  float x = 0, y = 0;
};

struct Vec3f {
  float x = 0, y = 0, z = 0;
  float operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }
  float& operator[](int i) { return i == 0 ? x : i == 1 ? y : z; }
};

inline Vec2f operator+(Vec2f a, Vec2f b) {
  return {a.x + b.x, a.y + b.y};
}
inline Vec2f operator-(Vec2f a, Vec2f b) {
  return {a.x - b.x, a.y - b.y};
}
inline Vec2f operator*(Vec2f a, float s) {
  return {a.x * s, a.y * s};
}
inline Vec2f operator*(float s, Vec2f a) {
  return a * s;
}

inline Vec3f operator+(Vec3f a, Vec3f b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vec3f operator-(Vec3f a, Vec3f b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vec3f operator-(Vec3f a) {
  return {-a.x, -a.y, -a.z};
}
inline Vec3f operator*(Vec3f a, Vec3f b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}
inline Vec3f operator*(Vec3f a, float s) {
  return {a.x * s, a.y * s, a.z * s};
}
inline Vec3f operator*(float s, Vec3f a) {
  return a * s;
}
inline Vec3f operator/(Vec3f a, float s) {
  return a * (1.0f / s);
}
inline Vec3f& operator+=(Vec3f& a, Vec3f b) {
  return a = a + b;
}
inline Vec3f& operator*=(Vec3f& a, Vec3f b) {
  return a = a * b;
}
inline Vec3f& operator*=(Vec3f& a, float s) {
  return a = a * s;
}

inline float dot(Vec2f a, Vec2f b) {
  return a.x * b.x + a.y * b.y;
}
inline float cross(Vec2f a, Vec2f b) {
  return a.x * b.y - a.y * b.x;
}
inline float dot(Vec3f a, Vec3f b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vec3f cross(Vec3f a, Vec3f b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline float length(Vec3f a) {
  return std::sqrt(dot(a, a));
}
/// The unit vector along a; a itself if its length is 0.
inline Vec3f normalised(Vec3f a) {
  const float squared = dot(a, a);
  return squared > 0 ? a * (1.0f / std::sqrt(squared)) : a;
}
inline bool is_finite(Vec3f a) {
  return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}
inline bool is_finite(Vec2f a) {
  return std::isfinite(a.x) && std::isfinite(a.y);
}
inline float min_component(Vec3f v) {
  return std::min(v.x, std::min(v.y, v.z));
}
inline float max_component(Vec3f a) {
  return std::max(a.x, std::max(a.y, a.z));
}
inline float mean(Vec3f a) {
  return (a.x + a.y + a.z) * (1.0f / 3.0f);
}

/// An orthonormal frame about a unit vector (Duff et al. 2017, "Building an orthonormal basis,
/// revisited").
struct Frame {
  Vec3f s, t, n;
  explicit Frame(Vec3f normal) : n(normal) {
    const float sign = std::copysign(1.0f, n.z);
    const float a = -1.0f / (sign + n.z), b = n.x * n.y * a;
    s = {1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x};
    t = {b, sign + n.y * n.y * a, -n.y};
  }
  Vec3f to_local(Vec3f v) const { return {dot(v, s), dot(v, t), dot(v, n)}; }
  Vec3f to_world(Vec3f v) const { return v.x * s + v.y * t + v.z * n; }
};

}  // namespace ohb
