#include "bake/padding.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "dataset/model/vec.h"

namespace ohb {
namespace {

/// One level of the pyramid: values that are averages over what was covered, and whether anything was.
struct Level {
  Image image;
  std::vector<uint8_t> is_covered;
};

/// Each texel is the average of the covered ones of its 2 x 2 block (smaller at odd borders).
template <int kChannels>
Level half_of_channels(const Image& image, const std::vector<uint8_t>& is_covered) {
  const int channels = kChannels > 0 ? kChannels : image.channels;
  Level half{Image((image.width_px + 1) / 2, (image.height_px + 1) / 2, channels), {}};
  half.is_covered.assign(static_cast<size_t>(half.image.width_px) * half.image.height_px, 0);
  tbb::parallel_for(0, half.image.height_px, [&](int y) {
    for (int x = 0; x < half.image.width_px; ++x) {
      float* const out = half.image.pixel(x, y);
      int count = 0;
      for (int sy = 2 * y; sy < std::min(2 * y + 2, image.height_px); ++sy)
        for (int sx = 2 * x; sx < std::min(2 * x + 2, image.width_px); ++sx) {
          if (!is_covered[static_cast<size_t>(sy) * image.width_px + sx]) continue;
          ++count;
          const float* const in = &image.values[(static_cast<size_t>(sy) * image.width_px + sx) * channels];
          for (int c = 0; c < channels; ++c) out[c] += in[c];
        }
      if (count == 0) continue;
      for (int c = 0; c < channels; ++c) out[c] /= static_cast<float>(count);
      half.is_covered[static_cast<size_t>(y) * half.image.width_px + x] = 1;
    }
  });
  return half;
}

/// The usual channels as constants: the loops over them unroll.
Level half_of(const Image& image, const std::vector<uint8_t>& is_covered) {
  return image.channels == 1   ? half_of_channels<1>(image, is_covered)
         : image.channels == 3 ? half_of_channels<3>(image, is_covered)
                               : half_of_channels<0>(image, is_covered);
}

/// Fills the holes of `image` from the complete image of half its size, bilinearly (weights 9, 3, 3, 1).
template <int kChannels>
void fill_channels_from_half(Image& image, const std::vector<uint8_t>& is_covered, const Image& half) {
  const int channels = kChannels > 0 ? kChannels : image.channels;
  const auto at = [&](const Image& of, int x, int y) {
    return &of.values[(static_cast<size_t>(y) * of.width_px + x) * channels];
  };
  tbb::parallel_for(0, image.height_px, [&](int y) {
    const int y0 = y / 2, y1 = std::clamp(y0 + (y % 2 ? 1 : -1), 0, half.height_px - 1);
    for (int x = 0; x < image.width_px; ++x) {
      if (is_covered[static_cast<size_t>(y) * image.width_px + x]) continue;
      const int x0 = x / 2, x1 = std::clamp(x0 + (x % 2 ? 1 : -1), 0, half.width_px - 1);
      const float *const p = at(half, x0, y0), *const q = at(half, x1, y0), *const r = at(half, x0, y1),
                         *const s = at(half, x1, y1);
      float* const out = &image.values[(static_cast<size_t>(y) * image.width_px + x) * channels];
      for (int c = 0; c < channels; ++c)
        out[c] = 0.5625f * p[c] + 0.1875f * q[c] + 0.1875f * r[c] + 0.0625f * s[c];
    }
  });
}

void fill_from_half(Image& image, const std::vector<uint8_t>& is_covered, const Image& half) {
  if (image.channels == 1) return fill_channels_from_half<1>(image, is_covered, half);
  if (image.channels == 3) return fill_channels_from_half<3>(image, is_covered, half);
  fill_channels_from_half<0>(image, is_covered, half);
}

}  // namespace

void pad(Image& image, const std::vector<uint8_t>& is_covered) {
  if (std::all_of(is_covered.begin(), is_covered.end(), [](uint8_t covered) { return covered != 0; })) return;
  if (image.width_px == 1 && image.height_px == 1) {
    std::fill(image.values.begin(), image.values.end(), 0.0f);
    return;
  }
  Level half = half_of(image, is_covered);
  pad(half.image, half.is_covered);
  fill_from_half(image, is_covered, half.image);
}

std::vector<Image> padded_levels(Image image, std::vector<uint8_t> is_covered) {
  if (is_covered.empty()) is_covered.assign(static_cast<size_t>(image.width_px) * image.height_px, 1);
  std::vector<Level> levels;
  levels.push_back({std::move(image), std::move(is_covered)});
  while (levels.back().image.width_px > 1 || levels.back().image.height_px > 1)
    levels.push_back(half_of(levels.back().image, levels.back().is_covered));
  std::vector<Image> images(levels.size());
  for (size_t l = levels.size(); l-- > 0;) {
    if (l + 1 < levels.size()) fill_from_half(levels[l].image, levels[l].is_covered, images[l + 1]);
    images[l] = std::move(levels[l].image);
  }
  return images;
}

void pad_normals(Image& image, const std::vector<uint8_t>& is_covered) {
  pad(image, is_covered);
  tbb::parallel_for(0, image.height_px, [&](int y) {
    for (int x = 0; x < image.width_px; ++x) {
      if (is_covered[static_cast<size_t>(y) * image.width_px + x]) continue;
      float* const n = image.pixel(x, y);
      const Vec3f unit = normalised({n[0], n[1], n[2]});
      const bool is_usable = dot(unit, unit) > 0.5f;
      n[0] = is_usable ? unit.x : 0;
      n[1] = is_usable ? unit.y : 0;
      n[2] = is_usable ? unit.z : 1;
    }
  });
}

}  // namespace ohb
