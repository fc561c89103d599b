// The maps of a texture set that its classes decide, from those of its faces and texels.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "bake/texture_set_bake.h"
#include "dataset/model/error.h"
#include "dataset/surface/covered_texels.h"
#include "dataset/surface/picture.h"

namespace ohb::bake {

ClassMaterial mix_classes(const MaterialTable& table, const std::array<float, kClassCount>& shares) {
  ClassMaterial mixed;
  for (int c = 0; c < kClassCount; ++c)
    for (const MaterialMap& map : kMaterialMaps) mixed.*map.value += shares[c] * table[c].*map.value;
  return mixed;
}

/// The shares of the classes as `label` wrote them, one channel a class; empty: borders are hard.
Image SetBake::class_shares() const {
  if (class_weights_.empty()) return {};
  const std::vector<ExrPart> parts = read_exr(class_weights_);
  const ExrPart& part = find_part(parts, "weights", class_weights_);
  Image shares(part.image.width_px, part.image.height_px, kClassCount);
  for (int c = 0; c < kClassCount; ++c) {  // files sort channels by name
    const auto channel = std::find(part.channels.begin(), part.channels.end(), kClassNames[c]);
    if (channel == part.channels.end())
      throw InputError(class_weights_.string(), "", std::string("has no channel '") + kClassNames[c] + "'",
                       "run `label` again");
    for (size_t i = 0; i < shares.values.size() / kClassCount; ++i)
      shares.values[kClassCount * i + static_cast<size_t>(c)] =
          part.image.values[part.channels.size() * i + static_cast<size_t>(channel - part.channels.begin())];
  }
  if (!std::all_of(shares.values.begin(), shares.values.end(), [](float s) { return std::isfinite(s); }))
    throw InputError(class_weights_.string(), "part 'weights'", "holds shares that are no numbers",
                     "run `label` again");
  return shares;
}

namespace {

constexpr uint8_t kMixed = kClassCount;

/// Where the pixels of `shares` have classes at all, and which class those have that have only one.
struct KnownShares {
  surface::ResampleWeights weights;
  std::vector<uint8_t> only_class;  // of each pixel; kMixed: several, or none
};

KnownShares known_shares(const Image& shares) {
  KnownShares known;
  known.weights.pixel_weights = Image(shares.width_px, shares.height_px, 1);
  known.only_class.assign(known.weights.pixel_weights.values.size(), kMixed);
  for (size_t i = 0; i < known.only_class.size(); ++i) {
    const float* const of_pixel = &shares.values[kClassCount * i];
    float sum = 0;
    for (int c = 0; c < kClassCount; ++c) sum += of_pixel[c];
    known.weights.pixel_weights.values[i] = sum;
    for (uint8_t c = 0; c < kClassCount; ++c)
      if (of_pixel[c] == 1 && sum == 1) known.only_class[i] = c;
  }
  return known;
}

std::array<ClassMaterial, kClassCount> pure_materials(const MaterialTable& table) {
  std::array<ClassMaterial, kClassCount> pure;
  for (int c = 0; c < kClassCount; ++c) {
    std::array<float, kClassCount> all_of_one{};
    all_of_one[c] = 1;
    pure[c] = mix_classes(table, all_of_one);
  }
  return pure;
}

}  // namespace

/// kMaterialMaps as channels, unpadded.
Image SetBake::class_values() const {
  constexpr float kLeastSum = 0.5f;  // less: no face was there when the shares were made
  const std::array<ClassMaterial, kClassCount> pure = pure_materials(table_);
  const Image shares = class_shares();
  const KnownShares known = known_shares(shares);
  std::optional<surface::Resampler> resampler;
  if (!shares.values.empty()) resampler.emplace(shares, width_px(), height_px(), known.weights);
  Image values(width_px(), height_px(), static_cast<int>(kMaterialMaps.size()));
  surface::for_each_covered_texel(coverage_, [&](int x, int y, uint32_t owner) {
    ClassMaterial out = pure[mesh_.model.triangles[triangles_.index[owner]].material_class];
    const uint8_t only = resampler ? resampler->common_byte(x, y, known.only_class, kMixed) : kMixed;
    if (only != kMixed) {
      out = pure[only];
    } else if (resampler) {
      std::array<float, kClassCount> here{};
      resampler->texel(x, y, here.data());
      const float sum = std::accumulate(here.begin(), here.end(), 0.0f);
      if (sum >= kLeastSum) {
        for (float& share : here) share /= sum;
        out = mix_classes(table_, here);
      }
    }
    float* const value = values.pixel(x, y);
    for (size_t m = 0; m < kMaterialMaps.size(); ++m) value[m] = out.*kMaterialMaps[m].value;
  });
  return values;
}

}  // namespace ohb::bake
