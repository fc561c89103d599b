// Roughness, specular and sss of a texture set, from the classes of its faces and texels.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <optional>

#include "bake/texture_set_bake.h"
#include "dataset/model/error.h"
#include "dataset/surface/picture.h"

namespace ohb::bake {

ClassMaterial mix_classes(const MaterialTable& table, const std::array<float, kClassCount>& shares) {
  ClassMaterial mixed;
  for (int c = 0; c < kClassCount; ++c) {
    mixed.specular += shares[c] * table[c].specular;
    mixed.roughness += shares[c] * table[c].roughness;
    mixed.sss += shares[c] * table[c].sss;
  }
  return mixed;
}

/// The shares of the classes as `label` wrote them, 4 channels; empty: borders are hard.
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
  return shares;
}

/// Roughness, specular and sss as three channels, unpadded.
Image SetBake::class_values() const {
  constexpr float kLeastSum = 0.5f;  // less: no face was there when the shares were made
  std::array<ClassMaterial, kClassCount> pure;
  for (int c = 0; c < kClassCount; ++c) {
    std::array<float, kClassCount> all_of_one{};
    all_of_one[c] = 1;
    pure[c] = mix_classes(table_, all_of_one);
  }
  const Image shares = class_shares();
  surface::ResampleWeights known;  // texels of faces
  known.pixel_weights = Image(shares.width_px, shares.height_px, 1);
  constexpr uint8_t kMixed = kClassCount;
  std::vector<uint8_t> only_class(known.pixel_weights.values.size(), kMixed);  // of each pixel, if it has one
  for (size_t i = 0; i < only_class.size(); ++i) {
    const float* const of_pixel = &shares.values[kClassCount * i];
    float sum = 0;
    for (int c = 0; c < kClassCount; ++c) sum += of_pixel[c];
    known.pixel_weights.values[i] = sum;
    for (uint8_t c = 0; c < kClassCount; ++c)
      if (of_pixel[c] == 1 && sum == 1) only_class[i] = c;
  }
  std::optional<surface::Resampler> resampler;
  if (!shares.values.empty()) resampler.emplace(shares, width_px(), height_px(), known);
  Image values(width_px(), height_px(), 3);
  tbb::parallel_for(0, height_px(), [&](int y) {
    for (int x = 0; x < width_px(); ++x) {
      const uint32_t owner = coverage_.owner_of(x, y);
      if (owner == surface::TexelCoverage::kNone) continue;
      ClassMaterial out = pure[mesh_.model.triangles[triangles_.index[owner]].material_class];
      const uint8_t only = resampler ? resampler->common_byte(x, y, only_class, kMixed) : kMixed;
      if (only != kMixed) {
        out = pure[only];
      } else if (resampler) {
        std::array<float, kClassCount> here{};
        resampler->texel(x, y, here.data());
        const float sum = here[0] + here[1] + here[2] + here[3];
        if (sum >= kLeastSum) {
          for (float& share : here) share /= sum;
          out = mix_classes(table_, here);
        }
      }
      float* const value = values.pixel(x, y);
      value[0] = out.roughness;
      value[1] = out.specular;
      value[2] = out.sss;
    }
  });
  return values;
}

}  // namespace ohb::bake
