#include "bake/mip_texture.h"

#include <Imath/half.h>

#include <algorithm>
#include <cmath>

#include "dataset/model/halves.h"
#include "dataset/surface/padding.h"

namespace ohb::bake {
namespace {

/// Footprints this close to one pixel are one pixel: rounding must not blur a mesh baked onto itself.
constexpr float kOnePixel = 1.02f;

/// The axes of the ellipse that a unit circle becomes: lengths, and the direction of the longer one.
struct Ellipse {
  float longer, shorter;
  Vec2f along;
};

Ellipse ellipse_of(Vec2f a, Vec2f b) {
  // Eigenvalues of J J^T, J = [a b].
  const float xx = a.x * a.x + b.x * b.x, yy = a.y * a.y + b.y * b.y, xy = a.x * a.y + b.x * b.y;
  const float mean = 0.5f * (xx + yy), half_difference = 0.5f * (xx - yy);
  const float spread = std::sqrt(half_difference * half_difference + xy * xy);
  const float larger = mean + spread;
  Vec2f along =
      half_difference >= 0 ? Vec2f{half_difference + spread, xy} : Vec2f{xy, spread - half_difference};
  const float size = std::sqrt(dot(along, along));
  along = size > 0 ? along * (1 / size) : Vec2f{1, 0};
  return {std::sqrt(larger), std::sqrt(std::max(0.0f, mean - spread)), along};
}

int wrapped(int i, int size) {
  if (i >= 0 && i < size) return i;
  const int rest = i % size;
  return rest < 0 ? rest + size : rest;
}

}  // namespace

MipTexture::MipTexture(Image picture, std::vector<uint8_t> is_shown) : channels_(picture.channels) {
  for (const Image& level : surface::padded_levels(std::move(picture), std::move(is_shown)))
    levels_.push_back({level.width_px, level.height_px, halves_of(level.values.data(), level.values.size())});
}

void MipTexture::add_bilinear(int level, Vec2f uv, float weight, float* out) const {
  const Level& l = levels_[level];
  const float scale = 1.0f / static_cast<float>(1 << level);
  const float x = (uv.x - std::floor(uv.x)) * static_cast<float>(levels_[0].width_px) * scale - 0.5f;
  const float y = (1 - (uv.y - std::floor(uv.y))) * static_cast<float>(levels_[0].height_px) * scale - 0.5f;
  const float x_whole = std::floor(x), y_whole = std::floor(y);
  const float fx = x - x_whole, fy = y - y_whole;
  const int column[2] = {wrapped(static_cast<int>(x_whole), l.width_px),
                         wrapped(static_cast<int>(x_whole) + 1, l.width_px)};
  const int row[2] = {wrapped(static_cast<int>(y_whole), l.height_px),
                      wrapped(static_cast<int>(y_whole) + 1, l.height_px)};
  const float wx[2] = {1 - fx, fx}, wy[2] = {weight * (1 - fy), weight * fy};
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 2; ++i) {
      const float w = wx[i] * wy[j];
      if (w == 0) continue;
      const uint16_t* const pixel =
          &l.halves[(static_cast<size_t>(row[j]) * l.width_px + column[i]) * channels_];
      for (int c = 0; c < channels_; ++c) out[c] += w * imath_half_to_float(pixel[c]);
    }
}

void MipTexture::sample(Vec2f uv, const UvFootprint& footprint, float* out) const {
  std::fill(out, out + channels_, 0.0f);
  const Vec2f size{static_cast<float>(levels_[0].width_px), static_cast<float>(levels_[0].height_px)};
  const auto in_pixels = [&](Vec2f step) { return Vec2f{step.x * size.x, step.y * size.y}; };
  const Ellipse ellipse = ellipse_of(in_pixels(footprint.across), in_pixels(footprint.up));
  if (!(ellipse.longer > kOnePixel)) return add_bilinear(0, uv, 1, out);

  const float narrow = std::max(ellipse.shorter, 1.0f);
  const int taps = std::clamp(static_cast<int>(std::ceil(ellipse.longer / narrow - 0.02f)), 1, kMostTaps);
  const float last = static_cast<float>(levels_.size() - 1);
  const float level =
      std::clamp(std::log2(std::max(narrow, ellipse.longer / static_cast<float>(taps))), 0.0f, last);
  const int finer = std::min(static_cast<int>(level), static_cast<int>(levels_.size()) - 1);
  const float to_coarser = level - static_cast<float>(finer);
  for (int i = 0; i < taps; ++i) {
    const float offset = ((static_cast<float>(i) + 0.5f) / static_cast<float>(taps) - 0.5f) * ellipse.longer;
    const Vec2f at{uv.x + offset * ellipse.along.x / size.x, uv.y + offset * ellipse.along.y / size.y};
    add_bilinear(finer, at, (1 - to_coarser) / static_cast<float>(taps), out);
    if (to_coarser > 0) add_bilinear(finer + 1, at, to_coarser / static_cast<float>(taps), out);
  }
}

}  // namespace ohb::bake
