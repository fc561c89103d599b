// Pictures of assets, as linear colour with alpha, read between texels.
#pragma once

#include <filesystem>
#include <vector>

#include "dataset/model/image.h"
#include "dataset/model/vec.h"

namespace ohb::people {

class Picture {
 public:
  /// One colour (linear), opaque.
  explicit Picture(Vec3f colour);
  /// The file's, sRGB to linear. Where the picture is nearly transparent, the colour of what is around.
  explicit Picture(const std::filesystem::path& file);

  /// Bilinear, repeating, v up.
  Vec3f colour(Vec2f uv) const;
  float opacity(Vec2f uv) const;

 private:
  void texels_of(Vec2f uv, size_t (&texel)[4], float (&weight)[4]) const;

  Image colour_;
  std::vector<float> alpha_;  // empty: opaque
};

}  // namespace ohb::people
