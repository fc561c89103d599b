#include "tests/bench/damaged_picture.h"

#include <unistd.h>

#include <algorithm>
#include <random>

#include "dataset/model/atomic_file.h"

namespace ohb {
namespace {

/// Replaces each diffuse picture by what `change` makes of it, embedded as PNG.
template <typename Change>
void change_pictures(Scan& scan, const Change& change) {
  for (ScanMaterial& material : scan.materials) {
    if (material.diffuse.empty()) continue;
    Image picture = read_image(material.diffuse);
    change(picture);
    const std::filesystem::path file =
        std::filesystem::temp_directory_path() / ("label_robot." + std::to_string(::getpid()) + ".png");
    write_png(file, picture);
    material.diffuse.embedded = std::make_shared<const std::string>(read_file(file));
    std::filesystem::remove(file);
  }
}

/// Running mean along one line of `count` values, `step` apart; the ends repeat.
void blur_line(float* first, int count, ptrdiff_t step, int radius) {
  std::vector<float> line(static_cast<size_t>(count));
  for (int i = 0; i < count; ++i) line[static_cast<size_t>(i)] = first[i * step];
  const auto at = [&](int i) { return double(line[static_cast<size_t>(std::clamp(i, 0, count - 1))]); };
  double sum = 0;
  for (int i = -radius; i <= radius; ++i) sum += at(i);
  for (int i = 0; i < count; ++i) {
    first[i * step] = static_cast<float>(sum / (2 * radius + 1));
    sum += at(i + radius + 1) - at(i - radius);
  }
}

}  // namespace

void add_noise(Scan& scan, double deviation) {
  change_pictures(scan, [&](Image& picture) {
    std::mt19937 random(7);
    std::normal_distribution<float> noise(0, static_cast<float>(deviation));
    for (float& value : picture.values) value = std::clamp(value + noise(random), 0.0f, 1.0f);
  });
}

void blur(Scan& scan, int radius_px) {
  change_pictures(scan, [&](Image& picture) {
    const ptrdiff_t pixel = picture.channels, row = pixel * picture.width_px;
    for (int c = 0; c < picture.channels; ++c) {
      for (int y = 0; y < picture.height_px; ++y)
        blur_line(&picture.values[static_cast<size_t>(y * row + c)], picture.width_px, pixel, radius_px);
      for (int x = 0; x < picture.width_px; ++x)
        blur_line(&picture.values[static_cast<size_t>(x * pixel + c)], picture.height_px, row, radius_px);
    }
  });
}

}  // namespace ohb
