#include "renderer/error_regions.h"

#include "dataset/model/parallel.h"
#include "dataset/model/regions.h"

namespace ohb::renderer {
namespace {

constexpr uint8_t kNothing = 255;
constexpr uint64_t kMiddleSeed = 0x6d6964646c65ull;

uint8_t class_at(const Picture& picture, int x, int y) {
  const Scene& scene = picture.context.scene;
  Random random(kMiddleSeed, static_cast<uint64_t>(y) * picture.settings.size_px + x, 0);
  RayCounts counts;
  Hit hit;
  const Ray ray = picture.view.ray(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
  const bool found = scene.cutout ? intersect<true>(scene, ray, random, counts, hit)
                                  : intersect<false>(scene, ray, random, counts, hit);
  return found ? scene.attributes[hit.triangle].material_class : kNothing;
}

}  // namespace

ErrorRegions error_regions(const Picture& picture) {
  const int size = picture.settings.size_px;
  std::vector<uint8_t> classes(picture.seen.size(), kNothing);
  parallel_for_each(picture.box.y0, picture.box.y1, [&](int y) {
    for (int x = picture.box.x0; x < picture.box.x1; ++x)
      classes[static_cast<size_t>(y) * size + x] = class_at(picture, x, y);
  });
  size_t counts[256] = {};
  for (const uint8_t c : classes) ++counts[c];
  ErrorRegions regions;
  regions.names = {"subject"};
  regions.pixels = {0};
  int region_of_class[256] = {};
  for (int c = 0; c < kClassCount; ++c)
    if (counts[c] >= kLeastRegion_px) {
      region_of_class[c] = static_cast<int>(regions.names.size());
      regions.names.emplace_back(kClassNames[c]);
      regions.pixels.push_back(counts[c]);
    }
  regions.of.resize(picture.seen.size());
  for (int y = picture.box.y0; y < picture.box.y1; ++y)
    for (int x = picture.box.x0; x < picture.box.x1; ++x) {
      const size_t pixel = static_cast<size_t>(y) * size + x;
      if (!picture.seen[pixel]) continue;
      regions.of[pixel].push_back(0);
      ++regions.pixels[0];
      if (region_of_class[classes[pixel]] > 0) regions.of[pixel].push_back(region_of_class[classes[pixel]]);
    }
  return regions;
}

double largest_error(const RegionTable& table) {
  double largest = 0;
  for (const std::vector<RegionSums>& light : table)
    for (const RegionSums& region : light) largest = std::max(largest, region.relative_error());
  return largest;
}

}  // namespace ohb::renderer
