// People found in photographs without a mask.
#include "learner/matting.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "dataset/model/atomic_file.h"
#include "dataset/model/colour.h"
#include "dataset/model/error.h"
#include "test_onnx.h"
#include "tests/support/test_files.h"

namespace ohb {
using namespace learner;
namespace {

struct Disc {
  double x, y, radius;
};

/// Exact coverage within a fifth of a percent, by 16 x 16 points a pixel.
float coverage_of(const Disc& disc, int x, int y) {
  int inside = 0;
  for (int i = 0; i < 256; ++i)
    inside += std::hypot(x + (i % 16 + 0.5) / 16 - disc.x, y + (i / 16 + 0.5) / 16 - disc.y) < disc.radius;
  return static_cast<float>(inside) / 256;
}

constexpr float kRed[3] = {0.5f, 0.03f, 0.03f};

/// Red discs on a bright checked wall, composited in linear light.
Photo discs_on_a_wall(const std::vector<Disc>& discs, int width, int height) {
  Photo photo;
  photo.linear = Image(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      float alpha = 0;
      for (const Disc& disc : discs) alpha = std::max(alpha, coverage_of(disc, x, y));
      const float wall = (x / 9 + y / 9) % 2 ? 0.8f : 0.7f;
      for (int c = 0; c < 3; ++c) photo.linear.pixel(x, y)[c] = alpha * kRed[c] + (1 - alpha) * wall;
    }
  return photo;
}

/// Intersection over union with the disc, soft.
double overlap(const Image& mask, const Disc& disc) {
  double both = 0, either = 0;
  for (int y = 0; y < mask.height_px; ++y)
    for (int x = 0; x < mask.width_px; ++x) {
      const double a = *mask.pixel(x, y), b = coverage_of(disc, x, y);
      both += std::min(a, b);
      either += std::max(a, b);
    }
  return both / either;
}

/// A network that takes for a person what is red and not green.
std::filesystem::path red_network(const TemporaryFolder& folder) {
  const std::filesystem::path file = folder / "red.onnx";
  write_file_atomically(file, colour_network({12, -12, 0}, -3));
  return file;
}

TEST(Matting, FindsTheLargestAndTheOthersByTheirRank) {
  const TemporaryFolder folder;
  const std::vector<Disc> discs = {{90, 120, 60}, {260, 70, 33}, {250, 170, 20}};
  const Photo photo = discs_on_a_wall(discs, 320, 240);
  for (int person = 1; person <= 3; ++person) {
    const Matte matte = find_person(photo, "photo.jpg", {red_network(folder), person});
    EXPECT_EQ(matte.people, 3);
    EXPECT_GT(overlap(matte.mask, discs[person - 1]), 0.97) << person;
  }
}

TEST(Matting, WhoIsSmallInALargePictureGetsASharpEdge) {
  const TemporaryFolder folder;
  const Disc disc = {700, 300, 45};  // the network sees the whole at a fifth of the size
  const Photo photo = discs_on_a_wall({disc}, 1200, 800);
  EXPECT_GT(overlap(find_person(photo, "photo.jpg", {red_network(folder), 1}).mask, disc), 0.97);
}

// Photographs larger than the matte is worked out at: the mask has the photo's size, and no rim stays.
TEST(Matting, OfLargePhotosHasTheirSize) {
  const TemporaryFolder folder;
  const int width = 4200, height = 3000;
  const double radius = 900;
  const auto coverage = [&](int x, int y) {
    return static_cast<float>(std::clamp(radius - std::hypot(x - 2000.0, y - 1500.0), 0.0, 1.0));
  };
  Photo photo;
  photo.linear = Image(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c) {
        const float alpha = coverage(x, y);
        photo.linear.pixel(x, y)[c] = alpha * kRed[c] + (1 - alpha) * 0.8f;
      }
  const Matte matte = find_person(photo, "photo.jpg", {red_network(folder), 1});
  ASSERT_EQ(matte.mask.width_px, width);
  ASSERT_EQ(matte.mask.height_px, height);
  keep_foreground_colours(photo, matte.mask);
  double both = 0, either = 0, green = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double found = *matte.mask.pixel(x, y), truth = coverage(x, y);
      both += std::min(found, truth);
      either += std::max(found, truth);
      green += found * photo.linear.pixel(x, y)[1];
    }
  EXPECT_GT(both / either, 0.97);
  EXPECT_NEAR(green / either, kRed[1], 0.01) << "of the bright wall nothing is left in the person";
}

TEST(Matting, WithoutANetworkTakesWhatDiffersFromTheBorders) {
  const Disc disc = {100, 90, 50};
  const Photo photo = discs_on_a_wall({disc}, 200, 180);
  EXPECT_GT(overlap(find_person(photo, "photo.jpg", {}).mask, disc), 0.95);
}

TEST(Matting, SaysWhatIsWrong) {
  const TemporaryFolder folder;
  const Photo photo = discs_on_a_wall({{100, 90, 50}}, 200, 180), empty = discs_on_a_wall({}, 200, 180);
  const auto cause_of = [&](const Photo& picture, const MattingOptions& options) -> std::string {
    try {
      find_person(picture, "photo.jpg", options);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  };
  const auto file_of = [&](const char* name, const std::string& content) {
    write_file_atomically(folder / name, content);
    return folder / name;
  };
  EXPECT_NE(cause_of(empty, {red_network(folder), 1}).find("nobody was found"), std::string::npos);
  EXPECT_NE(cause_of(photo, {red_network(folder), 2}).find("only 1 found"), std::string::npos);
  EXPECT_NE(cause_of(photo, {folder / "none.onnx", 1}).find("no such file"), std::string::npos);
  for (const std::string& content : {std::string(), std::string("no network"), std::string(5000, '\x7f'),
                                     colour_network({1, 1, 1}, 0).substr(0, 120)})
    EXPECT_NE(cause_of(photo, {file_of("bad.onnx", content), 1}).find("bad.onnx"), std::string::npos);
  EXPECT_NE(cause_of(photo, {file_of("two.onnx", colour_network({12, -12, 0}, -3, 2)), 1}).find("one plane"),
            std::string::npos);
  EXPECT_NE(cause_of(photo, {file_of("nan.onnx", colour_network({NAN, 0, 0}, 0)), 1}).find("NaN"),
            std::string::npos);
}

TEST(Matting, SurvivesDamagedNetworks) {
  const TemporaryFolder folder;
  const std::string whole = colour_network({12, -12, 0}, -3);
  const Photo photo = discs_on_a_wall({{24, 24, 14}}, 48, 48);
  std::mt19937 random(1);
  int refused = 0;
  // Number 2403 ends OpenCV 4.6's reader with a segmentation fault; most others are refused or read.
  for (int i = 0; i < 2420; ++i) {
    std::string damaged = whole;
    for (uint32_t bytes = 1 + random() % 4; bytes > 0; --bytes)
      damaged[random() % damaged.size()] = static_cast<char>(random());
    if (i >= 100 && i < 2400) continue;
    const std::filesystem::path file = folder / "damaged.onnx";
    write_file_atomically(file, damaged);
    try {
      find_person(photo, "photo.jpg", {file, 1});
    } catch (const InputError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 20);
}

TEST(ForegroundColours, LoseTheRimOfABrightBackground) {
  const Disc disc = {64, 64, 40};
  Photo photo = discs_on_a_wall({disc}, 128, 128);
  Image mask(128, 128, 1);
  double before = 0, after = 0;
  for (int y = 0; y < 128; ++y)
    for (int x = 0; x < 128; ++x) *mask.pixel(x, y) = coverage_of(disc, x, y);
  const auto worst_green = [&] {
    double worst = 0;
    for (size_t p = 0; p < mask.values.size(); ++p)
      if (mask.values[p] > 0.1f)
        worst = std::max(worst, std::abs(photo.linear.values[3 * p + 1] - double(kRed[1])));
    return worst;
  };
  before = worst_green();
  keep_foreground_colours(photo, mask);
  after = worst_green();
  EXPECT_GT(before, 0.5) << "the wall shines through the edge";
  EXPECT_LT(after, 0.06);
  EXPECT_FLOAT_EQ(photo.linear.pixel(64, 64)[0], kRed[0]) << "the inside stays";
}

}  // namespace
}  // namespace ohb
