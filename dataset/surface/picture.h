// A scan's pictures, resampled to the texels of a map.
#pragma once

#include <cstdint>
#include <vector>

#include "dataset/model/image.h"
#include "dataset/model/scan.h"

namespace ohb::surface {

/// Which way the green channel of a scan's normal map points: up (OpenGL), down (DirectX: turned over), or
/// not known (read as up, with a warning).
enum class GreenChannel { kUp, kDown, kUnclear };

/// Colours as linear Rec. 709, 3 channels. Integer pictures (PNG, JPEG, TIFF) are taken as sRGB-encoded and
/// decoded by the piecewise curve (IEC 61966-2-1); float pictures (EXR, HDR) as linear already. One or two
/// channels are grey. Throws InputError as read_image, and for a NaN or infinite pixel.
Image read_colour_picture(const ScanPicture& picture);

/// Opacity of a material's cut-out, 1 channel in [0,1]; stored values are linear. The alpha channel if there
/// is one, else red. In a picture of its own an alpha that is 1 everywhere says nothing (editors add it to a
/// white-on-black mask): then the mean of its colours. Throws as read_colour_picture.
Image read_alpha_picture(const ScanMaterial& material);

/// Tangent-space normals, 3 channels, unit length, +Y up. Integer pictures are decoded as 2 v - 1, float ones
/// taken as signed. `green_is_down` (DirectX) negates Y. Vectors too short to tell a direction become (0,0,1)
/// and are counted in `zero_length`. Throws as read_colour_picture, and for fewer than 3 channels.
Image read_normal_picture(const ScanPicture& picture, bool green_is_down, uint64_t& zero_length);

/// How the values of a picture reach a map. Along each axis: where the map has fewer texels than the picture,
/// the average over the texel's footprint (area-weighted box); where it has more, bilinear interpolation at
/// the texel's centre; where it has as many, the pixel itself, exactly. Repeats beyond the borders.
struct ResampleWeights {
  /// 1 channel, size of the picture, >= 0; empty: all 1. Texels whose pixels all weigh 0 use equal weights.
  Image pixel_weights;
};
Image resample(Image picture, int width_px, int height_px, const ResampleWeights& weights = {});

/// The same, texel by texel. The picture and its weights must outlive this.
class Resampler {
 public:
  Resampler(const Image& picture, int width_px, int height_px, const ResampleWeights& weights);
  /// `out`: as many values as the picture has channels.
  void texel(int x, int y, float* out) const;
  /// Of one byte a pixel of the picture: the one that all pixels have which the texel reads, or `none`.
  uint8_t common_byte(int x, int y, const std::vector<uint8_t>& of_pixel, uint8_t none) const;

 private:
  /// The pixels that the texels along one axis read.
  struct Taps {
    std::vector<int> first;      // of each texel; may lie outside the picture: it repeats
    std::vector<size_t> begin;   // its weights: [begin[i], begin[i + 1])
    std::vector<float> weights;  // of each texel: sum 1
    Taps(int picture_px, int map_px);
  };
  template <int kChannels>
  float accumulate(const Image* pixel_weights, int x, int y, float* out) const;
  template <int kChannels>
  void texel_of(int x, int y, float* out) const;

  const Image& picture_;
  const Image* pixel_weights_;  // null: all 1
  Taps columns_, rows_;
};

/// Makes each pixel of a 3-channel image a unit vector; (0,0,1) where it has no length. Gives their number.
uint64_t normalise_pixels(Image& image);

}  // namespace ohb::surface
