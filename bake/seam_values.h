// What differs between colours and directions when seams are made to agree: how far apart two lookups are,
// what a change of a texel does to that, and what a texel may hold.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "bake/seam_places.h"
#include "bake/seam_system.h"
#include "bake/seams.h"
#include "dataset/model/colour.h"

namespace ohb::bake {

/// What seams may differ by: 1/255 of a stored value or of a colour's sRGB encoding, 1 degree.
constexpr float kSeamLimit = 1.0f / 255, kNormalSeamLimit_degrees = 1;

/// What a place pulls with at first, in what a texel of the background resists with, where the difference is
/// counted as it is seen.
constexpr double kFirstWeight = 100;

using SideValues = std::array<Vec3f, 2>;  // of lookups on the two sides

/// Colours and other values in [0,1]: each channel a column.
class ColourSeams {
 public:
  using System = SeamSystem<1, 3>;

  explicit ColourSeams(bool is_linear) : is_linear_(is_linear) {}

  /// In limits.
  float apart(uint32_t, float, const SideValues& value) const {
    float most = 0;
    for (int c = 0; c < 3; ++c) {
      const float difference = std::fabs(value[0][c] - value[1][c]);
      // Encoding is dear: not where its steepest slope leaves no doubt.
      constexpr float kSteepest = 12.92f, kSurelyAgree = 0.3f * kSeamLimit;
      if (!is_linear_ || kSteepest * difference < kSurelyAgree)
        most = std::max(most, difference);
      else
        most = std::max(most, std::fabs(linear_to_srgb(value[0][c]) - linear_to_srgb(value[1][c])));
    }
    return most / kSeamLimit;
  }

  double first_weight(const SideValues& value) const {
    if (!is_linear_) return kFirstWeight;
    const Vec3f middle = 0.5f * (value[0] + value[1]);
    const float darkest = std::min({middle.x, middle.y, middle.z});
    const float slope = darkest <= 0.0031308f ? 12.92f : 1.055f / 2.4f * std::pow(darkest, 1 / 2.4f - 1);
    return kFirstWeight * slope * slope;
  }

  void linearise(const SeamPlace& place, const SideValues& value, const std::vector<Vec3f>&,
                 System::Row& row) const {
    const Vec3f difference = value[0] - value[1];
    row.difference = {difference.x, difference.y, difference.z};
    for (int k = 0; k < 2; ++k)
      for (int j = 0; j < 4; ++j) row.effect[4 * k + j][0] = (k == 0 ? 1 : -1) * place.weight[k][j];
  }

  /// What takes a texel back to what it was.
  static System::Value back(Vec3f texel, Vec3f before) {
    return {before.x - texel.x, before.y - texel.y, before.z - texel.z};
  }

  /// Where to look whether places are enough: there a quadratic is highest above them.
  static constexpr int kPointsBetween = 1;

  /// The system is linear: no step can lead astray.
  static constexpr bool kCanStray = false;
  static void calm(Vec3f&) {}

  /// Gives whether the texel ran into a border.
  static bool change(Vec3f& texel, const System::Value& by) {
    bool is_clamped = false;
    for (int c = 0; c < 3; ++c) {
      constexpr float kRounding = 1e-5f;
      const float value = texel[c] + static_cast<float>(by[c]);
      texel[c] = std::clamp(value, 0.0f, 1.0f);
      is_clamped = is_clamped || std::fabs(value - texel[c]) > kRounding;
    }
    return is_clamped;
  }

 private:
  bool is_linear_;
};

/// Directions: a texel's change is two numbers, along two axes perpendicular to it.
class NormalSeams {
 public:
  using System = SeamSystem<2, 1>;

  explicit NormalSeams(const std::vector<Seam>& seams) : seams_(seams) {}

  float apart(uint32_t seam, float along, const SideValues& value) const {
    constexpr float kDegrees = 57.29577951f;
    const Vec3f a = to_model(frame_at(seams_[seam].side[0], along), value[0]);
    const Vec3f b = to_model(frame_at(seams_[seam].side[1], along), value[1]);
    return kDegrees / kNormalSeamLimit_degrees * std::atan2(length(cross(a, b)), dot(a, b));
  }

  double first_weight(const SideValues&) const { return kFirstWeight; }

  void linearise(const SeamPlace& place, const SideValues& value, const std::vector<Vec3f>& texels,
                 System::Row& row) const {
    constexpr float kShortest = 1e-3f;
    SeamFrame frame[2];
    Vec3f direction[2];
    float scale[2];
    for (int k = 0; k < 2; ++k) {
      frame[k] = frame_at(seams_[place.seam].side[k], place.along);
      direction[k] = to_model(frame[k], value[k]);
      scale[k] = 1 / std::max(length(direction[k]), kShortest);
    }
    const Vec3f difference = scale[0] * direction[0] - scale[1] * direction[1];
    const Frame across(normalised(scale[0] * direction[0] + scale[1] * direction[1]));
    row.difference = {dot(difference, across.s), dot(difference, across.t)};
    for (int k = 0; k < 2; ++k)
      for (int j = 0; j < 4; ++j) {
        const Frame axes(texels[place.texel[k][j]]);
        const float weight = (k == 0 ? 1 : -1) * place.weight[k][j] * scale[k];
        const Vec3f by_a = to_model(frame[k], weight * axes.s), by_b = to_model(frame[k], weight * axes.t);
        row.effect[4 * k + j] = {dot(by_a, across.s), dot(by_b, across.s),  //
                                 dot(by_a, across.t), dot(by_b, across.t)};
      }
  }

  static System::Value back(Vec3f texel, Vec3f before) {
    const Frame axes(texel);
    return {dot(axes.s, before - texel), dot(axes.t, before - texel)};
  }

  /// Frames turn along an edge and lengths change: no quadratics.
  static constexpr int kPointsBetween = 3;

  /// Where texels side by side point away from each other, lookups between are short and turn quickly.
  static constexpr bool kCanStray = true;
  /// Half way to the smooth normal, which is the same on both sides of a seam.
  static void calm(Vec3f& texel) { texel = normalised(texel + Vec3f{0, 0, 1.01f}); }

  static bool change(Vec3f& texel, const System::Value& by) {
    constexpr double kMostTurn = 0.5;  // radians, about: beyond, a step says little
    const double turn = std::hypot(by[0], by[1]), share = turn > kMostTurn ? kMostTurn / turn : 1;
    const Frame axes(texel);
    texel = normalised(texel + static_cast<float>(share * by[0]) * axes.s +
                       static_cast<float>(share * by[1]) * axes.t);
    return false;
  }

 private:
  const std::vector<Seam>& seams_;
};

}  // namespace ohb::bake
