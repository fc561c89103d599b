#include "dataset/surface/padding.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>

#include "dataset/model/vec.h"

namespace ohb::surface {
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
  const auto at = [&](const Image& picture, int x, int y) {
    return &picture.values[(static_cast<size_t>(y) * picture.width_px + x) * channels];
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

/// Calls visit(i) for each i of a row of bytes that holds `wanted`.
template <typename Visit>
void for_each_byte(const uint8_t* row, int count, uint8_t wanted, const Visit& visit) {
  const uint8_t* const end = row + count;
  for (const uint8_t* at = row; at < end; ++at) {
    if (*at != wanted)
      at = static_cast<const uint8_t*>(std::memchr(at, wanted, static_cast<size_t>(end - at)));
    if (!at) return;
    visit(static_cast<int>(at - row));
  }
}

/// The other of the two neighbours in the halved image that a hole reads along an axis.
int neighbour_in_half(int i, int half_size) {
  return std::clamp(i / 2 + (i % 2 ? 1 : -1), 0, half_size - 1);
}

/// A level of the pyramid of which only the texels are made that the holes end up reading: beside large
/// charts they are few.
struct SparseLevel {
  int width_px, height_px;
  const uint8_t* is_covered;            // 0 or 1
  std::vector<uint8_t> covered_of_own;  // what it points to, but for the finest: that is the caller's
  std::vector<uint8_t> is_read;         // 0 or 1
  std::unique_ptr<float[]> values;      // only of texels that are read
  size_t at(int x, int y) const { return static_cast<size_t>(y) * width_px + x; }

  SparseLevel(int width, int height, const uint8_t* covered)
      : width_px(width), height_px(height), is_covered(covered) {}

  SparseLevel half() const {
    SparseLevel half((width_px + 1) / 2, (height_px + 1) / 2, nullptr);
    half.covered_of_own.resize(half.at(0, half.height_px));
    half.is_covered = half.covered_of_own.data();
    half.is_read.resize(half.covered_of_own.size());
    tbb::parallel_for(0, half.height_px, [&](int y) {
      const uint8_t* const upper = &is_covered[at(0, 2 * y)];
      const uint8_t* const lower = &is_covered[at(0, std::min(2 * y + 1, height_px - 1))];
      uint8_t* const out = &half.covered_of_own[half.at(0, y)];
      for (int x = 0; x < width_px / 2; ++x)
        out[x] = upper[2 * x] | upper[2 * x + 1] | lower[2 * x] | lower[2 * x + 1];
      if (width_px % 2) out[half.width_px - 1] = upper[width_px - 1] | lower[width_px - 1];
    });
    return half;
  }

  /// Marks what this level's holes read of its half. All holes are read: they lie in larger ones or are the
  /// finest.
  void mark_reads_of_holes(SparseLevel& half) const {
    tbb::parallel_for(0, half.height_px, [&](int y) {
      uint8_t* const row = &half.is_read[half.at(0, y)];
      for (int from = std::max(0, 2 * y - 1); from <= std::min(2 * y + 2, height_px - 1); ++from)
        if (from / 2 == y || neighbour_in_half(from, half.height_px) == y)
          for_each_byte(&is_covered[at(0, from)], width_px, 0,
                        [&](int x) { row[x / 2] = row[neighbour_in_half(x, half.width_px)] = 1; });
    });
  }

  /// Marks the covered texels that the means of its half are made of.
  void mark_reads_of_means(const SparseLevel& half) {
    tbb::parallel_for(0, height_px, [&](int y) {
      for_each_byte(&half.is_read[half.at(0, y / 2)], half.width_px, 1, [&](int half_x) {
        for (int x = 2 * half_x; x < std::min(2 * half_x + 2, width_px); ++x)
          is_read[at(x, y)] |= is_covered[at(x, y)];
      });
    });
  }
};

/// The means of a level's blocks from the values of the finer one, where they are read.
template <int kChannels>
void pull(const SparseLevel& fine, const float* fine_values, int channel_count, SparseLevel& level) {
  const int channels = kChannels > 0 ? kChannels : channel_count;
  level.values.reset(new float[level.is_read.size() * channels]);
  tbb::parallel_for(0, level.height_px, [&](int y) {
    for_each_byte(&level.is_read[level.at(0, y)], level.width_px, 1, [&](int x) {
      if (!level.is_covered[level.at(x, y)]) return;
      float* const out = &level.values[level.at(x, y) * channels];
      std::fill(out, out + channels, 0.0f);
      int count = 0;
      for (int sy = 2 * y; sy < std::min(2 * y + 2, fine.height_px); ++sy)
        for (int sx = 2 * x; sx < std::min(2 * x + 2, fine.width_px); ++sx) {
          if (!fine.is_covered[fine.at(sx, sy)]) continue;
          ++count;
          const float* const in = &fine_values[fine.at(sx, sy) * channels];
          for (int c = 0; c < channels; ++c) out[c] += in[c];
        }
      for (int c = 0; c < channels; ++c) out[c] /= static_cast<float>(count);
    });
  });
}

/// Fills the holes of a level from its half.
template <int kChannels>
void push(const SparseLevel& half, int channel_count, const SparseLevel& level, float* values) {
  const int channels = kChannels > 0 ? kChannels : channel_count;
  tbb::parallel_for(0, level.height_px, [&](int y) {
    const int y0 = y / 2, y1 = neighbour_in_half(y, half.height_px);
    for_each_byte(&level.is_covered[level.at(0, y)], level.width_px, 0, [&](int x) {
      const int x0 = x / 2, x1 = neighbour_in_half(x, half.width_px);
      const float* const p = &half.values[half.at(x0, y0) * channels];
      const float* const q = &half.values[half.at(x1, y0) * channels];
      const float* const r = &half.values[half.at(x0, y1) * channels];
      const float* const s = &half.values[half.at(x1, y1) * channels];
      float* const out = &values[level.at(x, y) * channels];
      for (int c = 0; c < channels; ++c)
        out[c] = 0.5625f * p[c] + 0.1875f * q[c] + 0.1875f * r[c] + 0.0625f * s[c];
    });
  });
}

template <int kChannels>
void pad_channels(Image& image, std::vector<SparseLevel>& levels) {
  const auto values_of = [&](size_t l) { return l == 0 ? image.values.data() : levels[l].values.get(); };
  for (size_t l = 1; l < levels.size(); ++l)
    pull<kChannels>(levels[l - 1], values_of(l - 1), image.channels, levels[l]);
  for (size_t l = levels.size() - 1; l-- > 0;)
    push<kChannels>(levels[l + 1], image.channels, levels[l], values_of(l));
}

}  // namespace

void pad(Image& image, const std::vector<uint8_t>& is_covered) {
  const auto has = [](const std::vector<uint8_t>& bytes, uint8_t wanted) {
    return std::memchr(bytes.data(), wanted, bytes.size()) != nullptr;
  };
  if (!has(is_covered, 0)) return;
  if (!has(is_covered, 1)) {
    std::fill(image.values.begin(), image.values.end(), 0.0f);
    return;
  }
  std::vector<SparseLevel> levels;
  levels.emplace_back(image.width_px, image.height_px, is_covered.data());
  do {
    levels.push_back(levels.back().half());
    levels[levels.size() - 2].mark_reads_of_holes(levels.back());
  } while (has(levels.back().covered_of_own, 0));
  for (size_t l = levels.size() - 1; l-- > 1;) levels[l].mark_reads_of_means(levels[l + 1]);
  if (image.channels == 1) return pad_channels<1>(image, levels);
  if (image.channels == 3) return pad_channels<3>(image, levels);
  pad_channels<0>(image, levels);
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
    const uint8_t* const row = &is_covered[static_cast<size_t>(y) * image.width_px];
    for_each_byte(row, image.width_px, 0, [&](int x) {
      float* const n = image.pixel(x, y);
      const Vec3f unit = normalised({n[0], n[1], n[2]});
      const bool is_usable = dot(unit, unit) > 0.5f;
      n[0] = is_usable ? unit.x : 0;
      n[1] = is_usable ? unit.y : 0;
      n[2] = is_usable ? unit.z : 1;
    });
  });
}

}  // namespace ohb::surface
