#include "dataset/environments/thumbnails.h"

#include <algorithm>
#include <cmath>

#include "dataset/environments/sphere_map.h"
#include "dataset/model/colour.h"

namespace ohb::environments {
namespace fs = std::filesystem;
namespace {

/// What radiance is multiplied with.
double brightness_of(const Image& map) {
  const LightStatistics light = statistics_of(map);
  const float mean_rgb[3] = {static_cast<float>(light.mean[0]), static_cast<float>(light.mean[1]),
                             static_cast<float>(light.mean[2])};
  const double mean = luminance_of(mean_rgb);
  if (mean <= 0) return 1;
  double sum = 0, total = 0;
  for (int y = 0; y < map.height_px; ++y) {
    const double weight = texel_solid_angle(y, map.width_px, map.height_px);
    for (int x = 0; x < map.width_px; ++x)
      sum += weight * std::log(luminance_of(map.pixel(x, y)) + 1e-3 * mean), total += weight;
  }
  return std::max(0.18 / std::exp(sum / total), 0.1 / mean);
}

}  // namespace

fs::path thumbnail_file(const fs::path& library, const std::string& id) {
  return library / "thumbnails" / (id + ".png");
}

ByteImage tone_mapped(const Image& map, int width_px) {
  const Image small = resampled(map, width_px);
  const double brightness = brightness_of(small);
  ByteImage picture(small.width_px, small.height_px, 3);
  for (size_t i = 0; i < picture.values.size(); ++i) {
    const auto x = static_cast<float>(brightness * static_cast<double>(small.values[i]));
    const float shown = std::min(1.0f, x * (1 + x / 16) / (1 + x));
    picture.values[i] = static_cast<uint8_t>(std::lround(255 * linear_to_srgb(shown)));
  }
  return picture;
}

void write_thumbnail(const fs::path& library, const std::string& id, const Image& map) {
  write_png(thumbnail_file(library, id), tone_mapped(map, kThumbnailWidth_px));
}

void write_thumbnail_sheet(const fs::path& library, const std::vector<std::string>& ids) {
  constexpr int kWidest_px = 8192;
  const int count = std::max(1, static_cast<int>(ids.size()));
  const int columns = std::max(1, static_cast<int>(std::ceil(std::sqrt(0.6 * count))));
  const int rows = (count + columns - 1) / columns;
  const int step = std::max(1, (columns * kThumbnailWidth_px + kWidest_px - 1) / kWidest_px);
  const int width = kThumbnailWidth_px / step, height = width / 2;
  constexpr int kGap_px = 4;
  ByteImage sheet(columns * (width + kGap_px), rows * (height + kGap_px), 3);
  for (size_t i = 0; i < ids.size(); ++i) {
    const Image image = read_image(thumbnail_file(library, ids[i]));
    const int left = static_cast<int>(i) % columns * (width + kGap_px);
    const int top = static_cast<int>(i) / columns * (height + kGap_px);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const float* from =
            image.pixel(std::min(x * step, image.width_px - 1), std::min(y * step, image.height_px - 1));
        const size_t to = 3 * (static_cast<size_t>(top + y) * static_cast<size_t>(sheet.width_px) +
                               static_cast<size_t>(left + x));
        for (size_t c = 0; c < 3; ++c)
          sheet.values[to + c] = static_cast<uint8_t>(std::lround(255 * from[c]));
      }
  }
  write_png(library / "sheet.png", sheet);
}

}  // namespace ohb::environments
