#include "bake/mip_texture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace ohb {
using namespace bake;
namespace {

Image noise(int width, int height, int channels) {
  Image image(width, height, channels);
  std::mt19937 random(1);
  std::uniform_real_distribution<float> any(0, 1);
  for (float& value : image.values) value = any(random);
  return image;
}

TEST(MipTexture, AFootprintOfOnePixelIsThePixel) {
  const Image picture = noise(20, 12, 3);
  const MipTexture texture(picture, {});
  for (int row = 0; row < 12; ++row)
    for (int x = 0; x < 20; ++x) {
      float rgb[3];
      const Vec2f uv{(x + 0.5f) / 20, 1 - (row + 0.5f) / 12};
      texture.sample(uv, {{1 / 20.0f, 0}, {0, 1 / 12.0f}}, rgb);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(rgb[c], picture.pixel(x, row)[c], 6e-4f);
      texture.sample({uv.x - 3, uv.y + 2}, {{0, 1 / 12.0f}, {1 / 20.0f, 0}}, rgb);  // turned, and repeated
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(rgb[c], picture.pixel(x, row)[c], 6e-4f);
    }
}

TEST(MipTexture, ABlockOfPixelsIsTheirMean) {
  const Image picture = noise(64, 64, 1);
  const MipTexture texture(picture, {});
  for (int block : {2, 8, 64})
    for (int row = 0; row < 64; row += block)
      for (int x = 0; x < 64; x += block) {
        double mean = 0;
        for (int j = 0; j < block; ++j)
          for (int i = 0; i < block; ++i) mean += *picture.pixel(x + i, row + j);
        const float step = block / 64.0f;
        float value;
        texture.sample({x / 64.0f + step / 2, 1 - row / 64.0f - step / 2}, {{step, 0}, {0, step}}, &value);
        EXPECT_NEAR(value, mean / (block * block), 1e-3f);
      }
}

TEST(MipTexture, LongFootprintsDoNotBlurAcross) {
  // Stripes along x: a footprint 16 pixels long along them and 1 across must tell them apart.
  Image stripes(64, 64, 1);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) *stripes.pixel(x, y) = static_cast<float>(y % 2);
  const MipTexture texture(stripes, {});
  float value;
  texture.sample({0.5f, 1 - 10.5f / 64}, {{8 / 64.0f, 0}, {0, 1 / 64.0f}}, &value);
  EXPECT_NEAR(value, 0, 1e-3f);
  texture.sample({0.5f, 1 - 11.5f / 64}, {{8 / 64.0f, 0}, {0, 1 / 64.0f}}, &value);
  EXPECT_NEAR(value, 1, 1e-3f);
}

TEST(MipTexture, PixelsThatNoFaceShowsNeverMixIn) {
  Image picture(32, 32, 1);
  std::vector<uint8_t> is_shown(32 * 32, 0);
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 32; ++x) {
      const bool inside = x >= 5 && x < 11;
      *picture.pixel(x, y) = inside ? 0.5f : 100.0f;
      is_shown[y * 32 + x] = inside;
    }
  const MipTexture texture(picture, is_shown);
  for (float reach : {1.0f, 3.0f, 20.0f}) {
    float value;
    texture.sample({0.3f, 0.3f}, {{reach / 32, 0}, {0, reach / 32}}, &value);
    EXPECT_NEAR(value, 0.5f, 1e-3f);
  }
}

}  // namespace
}  // namespace ohb
