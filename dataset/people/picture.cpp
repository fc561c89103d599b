#include "dataset/people/picture.h"

#include <array>
#include <cmath>

#include "dataset/model/colour.h"
#include "dataset/surface/padding.h"

namespace ohb::people {
namespace {

const std::array<float, 256>& linear_of_byte() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> values{};
    for (size_t i = 0; i < values.size(); ++i) values[i] = srgb_to_linear(static_cast<float>(i) / 255);
    return values;
  }();
  return table;
}

}  // namespace

Picture::Picture(Vec3f colour) : colour_(1, 1, 3) {
  for (int i = 0; i < 3; ++i) colour_.values[static_cast<size_t>(i)] = colour[i];
}

Picture::Picture(const std::filesystem::path& file) {
  const Image image = read_image(file);
  colour_ = Image(image.width_px, image.height_px, 3);
  const size_t count = static_cast<size_t>(image.width_px) * image.height_px;
  const auto channels = static_cast<size_t>(image.channels);
  const bool has_colour = channels >= 3, has_alpha = channels == 2 || channels == 4;
  if (has_alpha) alpha_.resize(count);
  for (size_t i = 0; i < count; ++i) {
    const float* from = &image.values[i * channels];
    for (size_t c = 0; c < 3; ++c) {
      const float value = std::fmin(std::fmax(from[has_colour ? c : 0], 0), 1);
      colour_.values[3 * i + c] = linear_of_byte()[static_cast<size_t>(std::lround(255 * value))];
    }
    if (has_alpha) alpha_[i] = from[channels - 1];
  }
  if (!has_alpha) return;
  std::vector<uint8_t> is_opaque(count);
  size_t empty = 0;
  for (size_t i = 0; i < count; ++i) is_opaque[i] = alpha_[i] > .4f, empty += !is_opaque[i];
  if (empty == 0)
    alpha_.clear();
  else if (empty < count)
    surface::pad(colour_, is_opaque);
}

void Picture::texels_of(Vec2f uv, size_t (&texel)[4], float (&weight)[4]) const {
  const auto wrap = [](float value, int size) {
    const int whole = static_cast<int>(value) % size;
    return whole < 0 ? whole + size : whole;
  };
  const float x = (uv.x - std::floor(uv.x)) * static_cast<float>(colour_.width_px) - .5f;
  const float v = 1 - uv.y;
  const float y = (v - std::floor(v)) * static_cast<float>(colour_.height_px) - .5f;
  const float left = std::floor(x), top = std::floor(y), s = x - left, t = y - top;
  for (int i = 0; i < 4; ++i) {
    const int column = wrap(left + static_cast<float>(i & 1), colour_.width_px);
    const int row = wrap(top + static_cast<float>(i >> 1), colour_.height_px);
    texel[i] = static_cast<size_t>(row) * static_cast<size_t>(colour_.width_px) + static_cast<size_t>(column);
    weight[i] = (i & 1 ? s : 1 - s) * (i >> 1 ? t : 1 - t);
  }
}

Vec3f Picture::colour(Vec2f uv) const {
  size_t texel[4];
  float weight[4];
  texels_of(uv, texel, weight);
  Vec3f sum;
  for (int i = 0; i < 4; ++i) {
    const float* from = &colour_.values[3 * texel[i]];
    sum += weight[i] * Vec3f{from[0], from[1], from[2]};
  }
  return sum;
}

float Picture::opacity(Vec2f uv) const {
  if (alpha_.empty()) return 1;
  size_t texel[4];
  float weight[4];
  texels_of(uv, texel, weight);
  float sum = 0;
  for (int i = 0; i < 4; ++i) sum += weight[i] * alpha_[texel[i]];
  return sum;
}

}  // namespace ohb::people
