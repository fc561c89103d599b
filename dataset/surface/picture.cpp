#include "dataset/surface/picture.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <stdexcept>

#include "dataset/model/colour.h"
#include "dataset/model/error.h"
#include "dataset/model/regions.h"

namespace ohb::surface {
namespace {

Image read_finite(const ScanPicture& picture, ImageFileInfo& info) {
  Image image = read_image(picture, &info);
  for (size_t i = 0; i < image.values.size(); ++i)
    if (!std::isfinite(image.values[i])) {
      const size_t pixel = i / image.channels, width = image.width_px;
      throw InputError(picture.file.string(),
                       "pixel (" + std::to_string(pixel % width) + ", " + std::to_string(pixel / width) + ")",
                       "is not a finite number", "export the picture again");
    }
  return image;
}

/// The linear value of each 16-bit code; 8-bit codes are multiples of 257.
std::vector<float> srgb_table() {
  std::vector<float> table(65536);
  for (int code = 0; code < 65536; ++code) table[code] = srgb_to_linear(static_cast<float>(code) / 65535.0f);
  return table;
}

int repeated(int i, int size) {
  if (i >= 0 && i < size) return i;
  const int rest = i % size;
  return rest < 0 ? rest + size : rest;
}

}  // namespace

Image read_colour_picture(const ScanPicture& picture) {
  ImageFileInfo info;
  const Image stored = read_finite(picture, info);
  static const std::vector<float> table = srgb_table();
  Image colour(stored.width_px, stored.height_px, 3);
  tbb::parallel_for(0, colour.height_px, [&](int y) {
    for (int x = 0; x < colour.width_px; ++x)
      for (int c = 0; c < 3; ++c) {
        const float value = stored.pixel(x, y)[stored.channels >= 3 ? c : 0];
        colour.pixel(x, y)[c] =
            info.is_float ? std::max(value, 0.0f)
                          : table[static_cast<size_t>(std::lround(std::clamp(value, 0.0f, 1.0f) * 65535))];
      }
  });
  return colour;
}

Image read_alpha_picture(const ScanMaterial& material) {
  ImageFileInfo info;
  const Image stored = read_finite(material.alpha, info);
  const int channel = info.has_alpha ? stored.channels - 1 : 0;
  Image alpha(stored.width_px, stored.height_px, 1);
  for (size_t i = 0; i < alpha.values.size(); ++i)
    alpha.values[i] = std::clamp(stored.values[i * stored.channels + channel], 0.0f, 1.0f);
  const auto is_opaque = [&alpha] {
    return std::all_of(alpha.values.begin(), alpha.values.end(), [](float a) { return a >= 1; });
  };
  if (channel == 0 || material.alpha.file == material.diffuse.file || !is_opaque()) return alpha;
  for (size_t i = 0; i < alpha.values.size(); ++i) {
    float sum = 0;
    for (int c = 0; c < channel; ++c) sum += stored.values[i * stored.channels + c];
    alpha.values[i] = std::clamp(sum / static_cast<float>(channel), 0.0f, 1.0f);
  }
  return alpha;
}

Image read_normal_picture(const ScanPicture& picture, bool green_is_down, uint64_t& zero_length) {
  ImageFileInfo info;
  const Image stored = read_finite(picture, info);
  if (stored.channels < 3)
    throw InputError(picture.file.string(), "",
                     "a normal map needs 3 channels, this has " + std::to_string(stored.channels),
                     "name a tangent-space normal map, or remove it from the material");
  Image normals(stored.width_px, stored.height_px, 3);
  for (size_t i = 0; i < normals.values.size(); ++i) {
    const float value = stored.values[i / 3 * stored.channels + i % 3];
    const float component = info.is_float ? value : 2 * value - 1;
    normals.values[i] = i % 3 == 1 && green_is_down ? -component : component;
  }
  zero_length = normalise_pixels(normals);
  return normals;
}

uint64_t normalise_pixels(Image& image) {
  // An 8-bit map stores "nothing" as 127 or 128 in each channel: no direction can be read from so short a
  // vector.
  constexpr float kShortest = 0.02f;
  std::atomic<uint64_t> zero_length{0};
  tbb::parallel_for(0, image.height_px, [&](int y) {
    uint64_t here = 0;
    for (int x = 0; x < image.width_px; ++x) {
      float* const n = image.pixel(x, y);
      Vec3f unit{0, 0, 1};
      if (length(Vec3f{n[0], n[1], n[2]}) > kShortest)
        unit = normalised({n[0], n[1], n[2]});
      else
        ++here;
      n[0] = unit.x;
      n[1] = unit.y;
      n[2] = unit.z;
    }
    zero_length += here;
  });
  return zero_length;
}

Resampler::Taps::Taps(int picture_px, int map_px) {
  const double scale = static_cast<double>(picture_px) / map_px;
  for (int i = 0; i < map_px; ++i) {
    begin.push_back(weights.size());
    if (picture_px == map_px) {
      first.push_back(i);
      weights.push_back(1);
    } else if (picture_px > map_px) {
      const double low = i * scale, high = (i + 1) * scale;
      first.push_back(static_cast<int>(std::floor(low)));
      for (int j = first.back(); j < high; ++j) {
        const double part = std::min<double>(high, j + 1) - std::max<double>(low, j);
        if (part > 1e-9) weights.push_back(static_cast<float>(part / scale));
      }
    } else {
      const double centre = (i + 0.5) * scale - 0.5, whole = std::floor(centre);
      const float next = static_cast<float>(centre - whole);
      first.push_back(static_cast<int>(whole));
      weights.push_back(1 - next);
      weights.push_back(next);
    }
  }
  begin.push_back(weights.size());
}

Resampler::Resampler(const Image& picture, int width_px, int height_px, const ResampleWeights& weights)
    : picture_(picture),
      pixel_weights_(weights.pixel_weights.values.empty() ? nullptr : &weights.pixel_weights),
      columns_(picture.width_px, width_px),
      rows_(picture.height_px, height_px) {}

/// Weighted sum of the picture over the two axes' taps; gives the sum of the weights.
template <int kChannels>
float Resampler::accumulate(const Image* pixel_weights, int x, int y, float* out) const {
  float total = 0;
  std::fill(out, out + kChannels, 0.0f);
  for (size_t j = rows_.begin[y]; j < rows_.begin[y + 1]; ++j) {
    const int row = repeated(rows_.first[y] + static_cast<int>(j - rows_.begin[y]), picture_.height_px);
    for (size_t i = columns_.begin[x]; i < columns_.begin[x + 1]; ++i) {
      const int column =
          repeated(columns_.first[x] + static_cast<int>(i - columns_.begin[x]), picture_.width_px);
      const size_t pixel = static_cast<size_t>(row) * picture_.width_px + column;
      float weight = rows_.weights[j] * columns_.weights[i];
      if (pixel_weights) weight *= pixel_weights->values[pixel];
      if (weight == 0) continue;
      for (int c = 0; c < kChannels; ++c) out[c] += weight * picture_.values[pixel * kChannels + c];
      total += weight;
    }
  }
  return total;
}

template <int kChannels>
void Resampler::texel_of(int x, int y, float* out) const {
  float total = accumulate<kChannels>(pixel_weights_, x, y, out);
  if (total < 1e-12f) total = accumulate<kChannels>(nullptr, x, y, out);
  for (int c = 0; c < kChannels; ++c) out[c] /= total;
}

void Resampler::texel(int x, int y, float* out) const {
  const int channels = picture_.channels;
  if (channels == 1) return texel_of<1>(x, y, out);
  if (channels == 3) return texel_of<3>(x, y, out);
  if (channels == 4) return texel_of<4>(x, y, out);
  if (channels == kClassCount) return texel_of<kClassCount>(x, y, out);  // shares of the classes
  throw std::logic_error("Resampler: channels");
}

uint8_t Resampler::common_byte(int x, int y, const std::vector<uint8_t>& of_pixel, uint8_t none) const {
  const auto byte_of = [&](int column, int row) {
    return of_pixel[static_cast<size_t>(repeated(row, picture_.height_px)) * picture_.width_px +
                    repeated(column, picture_.width_px)];
  };
  const int height = static_cast<int>(rows_.begin[y + 1] - rows_.begin[y]);
  const int width = static_cast<int>(columns_.begin[x + 1] - columns_.begin[x]);
  const uint8_t first = byte_of(columns_.first[x], rows_.first[y]);
  for (int j = 0; j < height; ++j)
    for (int i = 0; i < width; ++i)
      if (byte_of(columns_.first[x] + i, rows_.first[y] + j) != first) return none;
  return first;
}

Image resample(Image picture, int width_px, int height_px, const ResampleWeights& weights) {
  if (picture.width_px == width_px && picture.height_px == height_px) return picture;
  const Resampler resampler(picture, width_px, height_px, weights);
  Image map(width_px, height_px, picture.channels);
  tbb::parallel_for(0, height_px, [&](int y) {
    for (int x = 0; x < width_px; ++x) resampler.texel(x, y, map.pixel(x, y));
  });
  return map;
}

}  // namespace ohb::surface
