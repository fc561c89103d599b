// A picture with its mip levels, for filtered lookups of any footprint.
#pragma once

#include <cstdint>
#include <vector>

#include "dataset/model/image.h"
#include "dataset/model/vec.h"

namespace ohb::bake {

/// How far a UV lookup reaches: the UV steps of one texel to the right and of one texel up in the map that is
/// being made.
struct UvFootprint {
  Vec2f across, up;
};

/// 1 or 3 channels as half floats, v up, repeated; 11 bytes a pixel at most with its levels.
class MipTexture {
 public:
  MipTexture() = default;
  /// `is_shown`: one byte a pixel; pixels that no face shows (0) never mix into a level, and are filled by
  /// pull-push. Empty: all are shown.
  MipTexture(Image picture, std::vector<uint8_t> is_shown);

  bool empty() const { return levels_.empty(); }
  int channels() const { return channels_; }

  /// The mean over the footprint's parallelogram around uv: up to kMostTaps trilinear lookups along its
  /// longer axis (Heckbert 1989 for the axes; McCormack et al. 1999, "Feline", for the taps). A footprint of
  /// one pixel or less is a bilinear lookup in the picture itself. `out` has channels() values.
  void sample(Vec2f uv, const UvFootprint& footprint, float* out) const;

  static constexpr int kMostTaps = 8;

 private:
  struct Level {
    int width_px, height_px;
    std::vector<uint16_t> halves;
  };
  void add_bilinear(int level, Vec2f uv, float weight, float* out) const;

  int channels_ = 0;
  std::vector<Level> levels_;  // level l halves level l - 1, rounded up
};

}  // namespace ohb::bake
