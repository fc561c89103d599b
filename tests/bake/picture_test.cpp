#include "dataset/surface/picture.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "dataset/model/colour.h"
#include "dataset/surface/padding.h"
#include "tests/support/test_files.h"

namespace ohb {
using namespace surface;
namespace {

ScanPicture write_picture(const TemporaryFolder& folder, const std::string& name, const Image& image,
                          int bits = 8) {
  write_png(folder / name, image, bits);
  return {folder / name, nullptr};
}

ScanMaterial cut_out(const ScanPicture& alpha) {
  ScanMaterial material;
  material.alpha = alpha;
  return material;
}

Image gradient(int width, int height, int channels) {
  Image image(width, height, channels);
  for (size_t i = 0; i < image.values.size(); ++i) image.values[i] = static_cast<float>(i * 37 % 256) / 255;
  return image;
}

TEST(Picture, ColoursAreDecodedByThePiecewiseCurve) {
  const TemporaryFolder folder;
  Image image(2, 1, 3);
  image.values = {128 / 255.0f, 0, 1, 5 / 255.0f, 10 / 255.0f, 11 / 255.0f};
  const Image colour = read_colour_picture(write_picture(folder, "c.png", image));
  EXPECT_NEAR(colour.values[0], 0.2158605f, 1e-6f);  // not 0.2140 (128 / 255 to the power of 2.2 is 0.2195)
  EXPECT_EQ(colour.values[1], 0.0f);
  EXPECT_EQ(colour.values[2], 1.0f);
  EXPECT_NEAR(colour.values[3], 5 / 255.0f / 12.92f, 1e-8f);
  EXPECT_NEAR(colour.values[5], srgb_to_linear(11 / 255.0f), 1e-8f);
}

TEST(Picture, SixteenBitsKeepTheirPrecision) {
  const TemporaryFolder folder;
  Image image(1, 1, 3);
  image.values = {30001 / 65535.0f, 1 / 65535.0f, 65534 / 65535.0f};
  const Image colour = read_colour_picture(write_picture(folder, "c.png", image, 16));
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(colour.values[c], srgb_to_linear(image.values[c]), 1e-7f);
}

TEST(Picture, FloatPicturesAreLinearAlready) {
  const TemporaryFolder folder;
  Image image(1, 1, 3);
  image.values = {0.5f, 2.0f, 0.25f};
  write_exr(folder / "c.exr", {{"c", {"R", "G", "B"}, ExrPart::Type::kFloat, image}}, {});
  EXPECT_EQ(read_colour_picture({folder / "c.exr", nullptr}).values, image.values);
}

TEST(Picture, GreyBecomesThreeChannels) {
  const TemporaryFolder folder;
  const Image colour = read_colour_picture(write_picture(folder, "g.png", gradient(4, 4, 1)));
  ASSERT_EQ(colour.channels, 3);
  EXPECT_EQ(colour.values[3], colour.values[5]);
}

TEST(Picture, AnAlphaThatIsOneEverywhereSaysNothingInAMask) {
  const TemporaryFolder folder;
  Image rgba(2, 1, 4);
  rgba.values = {1, 1, 1, 1, 0, 0, 0, 1};
  ScanMaterial mask = cut_out(write_picture(folder, "m.png", rgba));
  EXPECT_EQ(read_alpha_picture(mask).values, (std::vector<float>{1, 0}));
  mask.diffuse = mask.alpha;  // a picture with its own alpha: all of it is opaque
  EXPECT_EQ(read_alpha_picture(mask).values, (std::vector<float>{1, 1}));
  rgba.values[7] = 0.6f;  // it says something
  EXPECT_NEAR(read_alpha_picture(cut_out(write_picture(folder, "n.png", rgba))).values[1], 0.6f, 1e-6f);
}

TEST(Picture, AlphaIsTheAlphaChannelElseRed) {
  const TemporaryFolder folder;
  Image rgba(1, 1, 4), rgb(1, 1, 3);
  rgba.values = {51 / 255.0f, 0, 0, 102 / 255.0f};
  rgb.values = {51 / 255.0f, 1, 1};
  EXPECT_FLOAT_EQ(read_alpha_picture(cut_out(write_picture(folder, "a.png", rgba))).values[0], 102 / 255.0f);
  EXPECT_FLOAT_EQ(read_alpha_picture(cut_out(write_picture(folder, "b.png", rgb))).values[0], 51 / 255.0f);
  // The colour below a low alpha is not darkened by it.
  EXPECT_FLOAT_EQ(read_colour_picture(write_picture(folder, "a.png", rgba)).values[0],
                  srgb_to_linear(51 / 255.0f));
}

TEST(Picture, NormalsAreUnitVectorsAndGreenTurnsOver) {
  const TemporaryFolder folder;
  Image image(2, 1, 3);
  image.values = {0.5f, 200 / 255.0f, 1, 127 / 255.0f, 128 / 255.0f, 127 / 255.0f};
  uint64_t zero = 0;
  const ScanPicture picture = write_picture(folder, "n.png", image);
  const Image up = read_normal_picture(picture, false, zero);
  EXPECT_EQ(zero, 1u);
  EXPECT_NEAR(length(Vec3f{up.values[0], up.values[1], up.values[2]}), 1, 1e-6f);
  EXPECT_GT(up.values[1], 0.4f);
  EXPECT_EQ(up.values[5], 1.0f);  // no direction: flat
  const Image down = read_normal_picture(picture, true, zero);
  EXPECT_EQ(down.values[1], -up.values[1]);
}

TEST(Picture, RefusesWhatIsNoNormalMapOrNotFinite) {
  const TemporaryFolder folder;
  uint64_t zero = 0;
  expect_message(input_error_of([&] {
                   read_normal_picture(write_picture(folder, "g.png", gradient(4, 4, 1)), false, zero);
                 }),
                 {"g.png", "a normal map needs 3 channels, this has 1"});
  Image image(2, 2, 3);
  image.values[7] = NAN;
  write_exr(folder / "n.exr", {{"n", {"R", "G", "B"}, ExrPart::Type::kHalf, image}}, {});
  const ScanPicture picture{folder / "n.exr", nullptr};
  expect_message(input_error_of([&] { read_normal_picture(picture, false, zero); }),
                 {"n.exr: pixel (0, 1)", "is not a finite number"});
  expect_message(input_error_of([&] { read_colour_picture(picture); }), {"n.exr: pixel (0, 1)"});
}

TEST(Resample, EqualSizeIsAnExactCopy) {
  const Image picture = gradient(13, 7, 3);
  EXPECT_EQ(resample(picture, 13, 7).values, picture.values);
}

TEST(Resample, SmallerIsTheMeanOfTheFootprint) {
  Image picture(3, 1, 1);
  picture.values = {0, 3, 9};
  const Image half = resample(picture, 2, 1);  // footprints [0, 1.5] and [1.5, 3]
  EXPECT_FLOAT_EQ(half.values[0], (0 + 0.5f * 3) / 1.5f);
  EXPECT_FLOAT_EQ(half.values[1], (0.5f * 3 + 9) / 1.5f);
  const Image big = gradient(64, 32, 3), small = resample(big, 16, 8);
  double mean_big = 0, mean_small = 0;
  for (float v : big.values) mean_big += v / static_cast<double>(big.values.size());
  for (float v : small.values) mean_small += v / static_cast<double>(small.values.size());
  EXPECT_NEAR(mean_big, mean_small, 1e-6);
}

TEST(Resample, LargerIsBilinearAndRepeats) {
  Image picture(2, 1, 1);
  picture.values = {0, 1};
  const Image map = resample(picture, 4, 1);  // centres at -0.25, 0.25, 0.75, 1.25 in pixels
  EXPECT_FLOAT_EQ(map.values[0], 0.25f);      // a quarter of the last pixel: the map repeats
  EXPECT_FLOAT_EQ(map.values[1], 0.25f);
  EXPECT_FLOAT_EQ(map.values[2], 0.75f);
  EXPECT_FLOAT_EQ(map.values[3], 0.75f);
}

TEST(Resample, WeightsKeepTheBackgroundOut) {
  Image picture(4, 1, 1);
  picture.values = {1, 100, 100, 100};
  Image weights(4, 1, 1);
  weights.values = {1, 0, 0, 0};
  const Image map = resample(picture, 2, 1, {weights});
  EXPECT_FLOAT_EQ(map.values[0], 1);
  EXPECT_FLOAT_EQ(map.values[1], 100);  // nothing weighs there: the plain mean
}

TEST(Padding, KeepsCoveredTexelsAndFillsTheRestFromThem) {
  for (const auto& [width, height] : {std::pair{64, 64}, {37, 5}, {1, 9}, {200, 131}}) {
    Image image(width, height, 2);
    std::vector<uint8_t> is_covered(static_cast<size_t>(width) * height, 0);
    for (size_t i = 0; i < is_covered.size(); ++i) {
      is_covered[i] = i % 17 == 3;
      image.values[2 * i] = is_covered[i] ? 0.25f + static_cast<float>(i % 5) / 8 : 1e9f;
      image.values[2 * i + 1] = is_covered[i] ? 7 : -1;
    }
    Image padded = image;
    pad(padded, is_covered);
    for (size_t i = 0; i < is_covered.size(); ++i) {
      if (is_covered[i]) {
        EXPECT_EQ(padded.values[2 * i], image.values[2 * i]);
      } else {
        EXPECT_GE(padded.values[2 * i], 0.25f);
        EXPECT_LE(padded.values[2 * i], 0.75f);
        EXPECT_FLOAT_EQ(padded.values[2 * i + 1], 7);
      }
    }
  }
}

/// Pull-push as its definition says, in doubles, with one value a texel.
std::vector<double> plain_pull_push(const std::vector<double>& values, const std::vector<uint8_t>& is_covered,
                                    int width, int height) {
  if (width == 1 && height == 1) return {is_covered[0] ? values[0] : 0};
  const int half_width = (width + 1) / 2, half_height = (height + 1) / 2;
  std::vector<double> sum(half_width * half_height), result = values;
  std::vector<int> count(sum.size());
  for (int i = 0; i < width * height; ++i) {
    if (!is_covered[i]) continue;
    const int block = i / width / 2 * half_width + i % width / 2;
    sum[block] += values[i];
    ++count[block];
  }
  std::vector<uint8_t> half_covered(sum.size());
  for (size_t b = 0; b < sum.size(); ++b) {
    half_covered[b] = count[b] > 0;
    if (count[b] > 0) sum[b] /= count[b];
  }
  const std::vector<double> half = plain_pull_push(sum, half_covered, half_width, half_height);
  for (int i = 0; i < width * height; ++i) {
    if (is_covered[i]) continue;
    // Bilinear, at the texel's centre in the half image, whose border repeats.
    const double x = (i % width + 0.5) / 2 - 0.5, y = (i / width + 0.5) / 2 - 0.5;
    double value = 0;
    for (int j = 0; j < 2; ++j)
      for (int k = 0; k < 2; ++k) {
        const int column = static_cast<int>(std::floor(x)) + k, row = static_cast<int>(std::floor(y)) + j;
        const double weight = (1 - std::fabs(x - column)) * (1 - std::fabs(y - row));
        value +=
            weight *
            half[std::clamp(row, 0, half_height - 1) * half_width + std::clamp(column, 0, half_width - 1)];
      }
    result[i] = value;
  }
  return result;
}

TEST(Padding, IsWhatAPlainLoopGives) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> any(0, 1);
  for (int channels : {1, 2, 3}) {
    Image image(37, 22, channels);
    std::vector<uint8_t> is_covered(37 * 22);
    for (float& value : image.values) value = any(random);
    for (uint8_t& covered : is_covered) covered = any(random) < 0.1f;
    const Image before = image;
    pad(image, is_covered);
    for (int c = 0; c < channels; ++c) {
      std::vector<double> values;
      for (size_t i = 0; i < is_covered.size(); ++i) values.push_back(before.values[channels * i + c]);
      const std::vector<double> expected = plain_pull_push(values, is_covered, 37, 22);
      for (size_t i = 0; i < expected.size(); ++i)
        EXPECT_NEAR(image.values[channels * i + c], expected[i], 1e-5) << channels << " " << i;
    }
  }
}

/// Only what the holes read is made of each level: the same bits as with all of it.
TEST(Padding, IsTheFinestOfTheWholeLevels) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> any(0, 1);
  for (float share : {0.0f, 0.002f, 0.3f, 0.98f, 1.0f})
    for (int channels : {1, 2, 3}) {
      Image image(131, 66, channels);
      std::vector<uint8_t> is_covered(131 * 66);
      for (float& value : image.values) value = any(random);
      for (uint8_t& covered : is_covered) covered = any(random) < share;
      for (int y = 10; y < 50; ++y) std::fill_n(&is_covered[131 * y + 20], 60, 1);  // a chart
      const std::vector<Image> levels = padded_levels(image, is_covered);
      pad(image, is_covered);
      EXPECT_EQ(image.values, levels[0].values) << share << " " << channels;
    }
}

TEST(Padding, EveryMipOfALoneChartIsItsColour) {
  Image image(256, 256, 1);
  std::vector<uint8_t> is_covered(256 * 256, 0);
  for (int y = 100; y < 140; ++y)
    for (int x = 30; x < 75; ++x) {
      is_covered[static_cast<size_t>(y) * 256 + x] = 1;
      *image.pixel(x, y) = 0.625f;
    }
  pad(image, is_covered);
  for (int size = 128; size >= 1; size /= 2)
    for (float value : resample(image, size, size).values) EXPECT_NEAR(value, 0.625f, 1e-6f);
}

TEST(Padding, NormalsStayUnitVectors) {
  Image image(16, 16, 3);
  std::vector<uint8_t> is_covered(256, 0);
  const Vec3f a = normalised({1, 0, 1}), b = normalised({-1, 0, 1});
  std::copy_n(&a.x, 3, image.pixel(2, 8));
  std::copy_n(&b.x, 3, image.pixel(13, 8));
  is_covered[8 * 16 + 2] = is_covered[8 * 16 + 13] = 1;
  pad_normals(image, is_covered);
  for (int i = 0; i < 256; ++i)
    EXPECT_NEAR(length(Vec3f{image.values[3 * i], image.values[3 * i + 1], image.values[3 * i + 2]}), 1,
                1e-5f);
  EXPECT_NEAR(image.pixel(1, 8)[0], a.x, 0.2f);
  // Nothing covered at all: flat.
  Image nothing(4, 4, 3);
  pad_normals(nothing, std::vector<uint8_t>(16, 0));
  EXPECT_EQ(nothing.pixel(3, 3)[2], 1.0f);
}

}  // namespace
}  // namespace ohb
