#include "renderer/coarser.h"

#include <algorithm>
#include <cmath>

#include "dataset/model/model_files.h"

namespace ohb::renderer {
namespace {

constexpr int kLeastWidth_px = 64;

/// row_weight(y): how much the row of that number counts.
template <typename RowWeight>
Image halved_by(const Image& image, const RowWeight& row_weight) {
  Image half(image.width_px / 2, image.height_px / 2, image.channels);
  for (int y = 0; y < half.height_px; ++y) {
    const double upper = row_weight(2 * y), lower = row_weight(2 * y + 1);
    const double scale = 0.5 / (upper + lower);
    for (int x = 0; x < half.width_px; ++x)
      for (int c = 0; c < image.channels; ++c)
        half.pixel(x, y)[c] = static_cast<float>(
            scale *
            (upper * (double{image.pixel(2 * x, 2 * y)[c]} + image.pixel(2 * x + 1, 2 * y)[c]) +
             lower * (double{image.pixel(2 * x, 2 * y + 1)[c]} + image.pixel(2 * x + 1, 2 * y + 1)[c])));
  }
  return half;
}

bool is_even(const Image& image) {
  return image.width_px % 2 == 0 && image.height_px % 2 == 0;
}

/// The maps that light meets, halved.
TextureSet halved_set(const TextureSet& set) {
  TextureSet half;
  half.name = set.name;
  for (const MapKind& kind : kMapKinds)
    if (kind.image != &TextureSet::displacement && !(set.*kind.image).values.empty())
      half.*kind.image = halved(set.*kind.image);
  return half;
}

}  // namespace

Image halved(const Image& image) {
  return halved_by(image, [](int) { return 1.0; });
}

Environment coarser_environment(const Environment& environment, int halvings) {
  Environment coarse = environment;
  for (int i = 0; i < halvings; ++i) {
    const Image& fine = coarse.radiance;
    if (!is_even(fine) || fine.width_px / 2 < kLeastWidth_px) break;
    coarse.radiance = halved_by(fine, [&](int y) { return std::sin(M_PI * (y + 0.5) / fine.height_px); });
  }
  return coarse;
}

Model with_coarser_maps(const Model& model, int size_px) {
  Model coarse;
  coarse.name = model.name;
  coarse.positions_cm = model.positions_cm;
  coarse.uvs = model.uvs;
  coarse.triangles = model.triangles;
  coarse.normals = model.normals;
  for (const TextureSet& set : model.sets) {
    const bool shrinks = set.albedo.width_px > size_px && is_even(set.albedo);
    coarse.sets.push_back(shrinks ? halved_set(set) : set);
    TextureSet& last = coarse.sets.back();
    while (last.albedo.width_px > size_px && is_even(last.albedo)) last = halved_set(last);
  }
  return coarse;
}

int largest_map_px(const Model& model) {
  int largest = 0;
  for (const TextureSet& set : model.sets) largest = std::max(largest, set.albedo.width_px);
  return largest;
}

}  // namespace ohb::renderer
