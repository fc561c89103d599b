// Photographs and masks of every kind.
#include "learner/photo.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <lcms2.h>

#include "dataset/model/colour.h"
#include "dataset/model/image_place.h"
#include "dataset/model/vec.h"
#include "tests/support/test_files.h"

namespace ohb {
using namespace learner;
namespace {

/// A grey picture with a person-like bright block in columns 20..39 and rows 10..49 of 60 x 64.
Image block_picture(int channels) {
  Image image(60, 64, channels);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 60; ++x)
      for (int c = 0; c < channels; ++c) {
        const bool inside = x >= 20 && x < 40 && y >= 10 && y < 50;
        image.pixel(x, y)[c] = channels % 2 == 0 && c == channels - 1 ? inside : inside ? 0.8f : 0.3f;
      }
  return image;
}

Image block_mask() {
  Image image(60, 64, 1);
  for (int y = 10; y < 50; ++y)
    for (int x = 20; x < 40; ++x) image.pixel(x, y)[0] = 1;
  return image;
}

void write_with(const std::filesystem::path& file, const Image& image, OIIO::TypeDesc type,
                const std::function<void(OIIO::ImageSpec&)>& change) {
  auto output = OIIO::ImageOutput::create(file.string());
  ASSERT_TRUE(output);
  OIIO::ImageSpec spec(image.width_px, image.height_px, image.channels, type);
  change(spec);
  ASSERT_TRUE(output->open(file.string(), spec)) << output->geterror();
  ASSERT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, image.values.data()));
  output->close();
}

TEST(Photo, UprightTurnsAllEightOrientations) {
  // Upright: 1 2 3 / 4 5 6. Stored as each orientation stores it.
  const std::vector<std::pair<int, std::vector<float>>> two_rows = {
      {1, {1, 2, 3, 4, 5, 6}}, {2, {3, 2, 1, 6, 5, 4}}, {3, {6, 5, 4, 3, 2, 1}}, {4, {4, 5, 6, 1, 2, 3}}};
  const std::vector<std::pair<int, std::vector<float>>> three_rows = {
      {5, {1, 4, 2, 5, 3, 6}}, {6, {3, 6, 2, 5, 1, 4}}, {7, {6, 3, 5, 2, 4, 1}}, {8, {4, 1, 5, 2, 6, 3}}};
  const std::vector<float> wanted = {1, 2, 3, 4, 5, 6};
  for (const auto& [orientation, values] : two_rows) {
    Image stored(3, 2, 1);
    stored.values = values;
    EXPECT_EQ(upright(stored, orientation).values, wanted) << orientation;
  }
  for (const auto& [orientation, values] : three_rows) {
    Image stored(2, 3, 1);
    stored.values = values;
    const Image turned = upright(stored, orientation);
    EXPECT_EQ(turned.width_px, 3) << orientation;
    EXPECT_EQ(turned.values, wanted) << orientation;
  }
}

TEST(Photo, ExifOrientationOfAFileIsFollowed) {
  TemporaryFolder folder;
  write_with(folder / "turned.tif", block_picture(3), OIIO::TypeDesc::UINT8,
             [](OIIO::ImageSpec& spec) { spec.attribute("Orientation", 6); });
  const Photo photo = read_photo(folder / "turned.tif");
  EXPECT_EQ(photo.linear.width_px, 64);
  EXPECT_EQ(photo.linear.height_px, 60);
  // Stored (20, 10) comes to x = 63 - 10, y = 20.
  EXPECT_NEAR(photo.linear.pixel(53, 20)[0], srgb_to_linear(0.8f), 3e-3);
}

TEST(Photo, GreyColourAlphaAndSixteenBitsGiveTheSame) {
  TemporaryFolder folder;
  for (const int channels : {1, 3, 4})
    for (const int bits : {8, 16}) {
      SCOPED_TRACE(std::to_string(channels) + " channels, " + std::to_string(bits) + " bits");
      write_png(folder / "p.png", block_picture(channels), bits);
      const Photo photo = read_photo(folder / "p.png");
      EXPECT_NEAR(photo.linear.pixel(25, 25)[2], srgb_to_linear(0.8f), 3e-3);
      EXPECT_NEAR(photo.linear.pixel(0, 0)[1], srgb_to_linear(0.3f), 3e-3);
      EXPECT_EQ(photo.alpha.values.empty(), channels != 4);
    }
}

TEST(Photo, CmykIsConvertedOrRefusedInWords) {
  TemporaryFolder folder;
  Image cmyk(32, 32, 4);
  write_with(folder / "c.tif", cmyk, OIIO::TypeDesc::UINT8, [](OIIO::ImageSpec& spec) {
    spec.channelnames = {"C", "M", "Y", "K"};
    spec.attribute("tiff:PhotometricInterpretation", 5);
    spec.attribute("tiff:ColorSpace", "CMYK");
    spec.alpha_channel = -1;
  });
  try {
    const Photo photo = read_photo(folder / "c.tif");  // no ink is white
    EXPECT_NEAR(photo.linear.pixel(5, 5)[0], 1, 0.02);
  } catch (const InputError& error) {
    expect_message(error.what(), {"c.tif", "RGB"});
  }
}

/// A profile of these primaries with sRGB's curve and white.
std::string profile_with(const cmsCIExyYTRIPLE& primaries) {
  const cmsCIExyY white{0.3127, 0.3290, 1};
  const double curve[] = {2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045};
  cmsToneCurve* encoded = cmsBuildParametricToneCurve(nullptr, 4, curve);
  cmsToneCurve* curves[] = {encoded, encoded, encoded};
  cmsHPROFILE profile = cmsCreateRGBProfile(&white, &primaries, curves);
  cmsUInt32Number size = 0;
  cmsSaveProfileToMem(profile, nullptr, &size);
  std::string bytes(size, '\0');
  cmsSaveProfileToMem(profile, bytes.data(), &size);
  cmsCloseProfile(profile);
  cmsFreeToneCurve(encoded);
  return bytes;
}

Photo photo_with(const TemporaryFolder& folder, const std::string& name, Vec3f stored,
                 const std::string& profile) {
  Image picture(32, 32, 3);
  for (size_t i = 0; i < picture.values.size(); ++i) picture.values[i] = stored[static_cast<int>(i % 3)];
  write_with(folder / name, picture, OIIO::TypeDesc::UINT8, [&](OIIO::ImageSpec& spec) {
    spec.attribute("CompressionQuality", 100);
    if (!profile.empty())
      spec.attribute("ICCProfile", OIIO::TypeDesc(OIIO::TypeDesc::UINT8, static_cast<int>(profile.size())),
                     profile.data());
  });
  return read_photo(folder / name);
}

/// Against the matrix from Display P3 to Rec. 709 (SMPTE EG 432-1's primaries, both of white D65).
TEST(Photo, ColoursFollowTheProfile) {
  const std::string display_p3 = profile_with({{0.680, 0.320, 1}, {0.265, 0.690, 1}, {0.150, 0.060, 1}});
  const std::string srgb = profile_with({{0.640, 0.330, 1}, {0.300, 0.600, 1}, {0.150, 0.060, 1}});
  const double matrix[3][3] = {{1.22494, -0.22494, 0}, {-0.04206, 1.04206, 0}, {-0.01964, -0.07864, 1.09827}};
  TemporaryFolder folder;
  for (const char* name : {"p.png", "p.jpg", "p.tif"})
    for (const Vec3f stored : {Vec3f{153, 102, 51}, Vec3f{204, 204, 204}, Vec3f{230, 26, 26}}) {
      SCOPED_TRACE(std::string(name) + " " + std::to_string(stored.x));
      const Vec3f encoded = (1 / 255.0f) * stored;
      const Photo plain = photo_with(folder, name, encoded, ""),
                  turned = photo_with(folder, name, encoded, display_p3);
      for (int c = 0; c < 3; ++c) {
        double expected = 0;
        for (int k = 0; k < 3; ++k) expected += matrix[c][k] * srgb_to_linear(encoded[k]);
        EXPECT_NEAR(turned.linear.pixel(9, 9)[c], std::clamp(expected, 0.0, 1.0), 0.006) << c;
      }
      EXPECT_EQ(photo_with(folder, name, encoded, srgb).linear.values, plain.linear.values);
      if (std::string(name) == "p.png") continue;  // libpng does not write a profile that is cut off
      EXPECT_EQ(photo_with(folder, name, encoded, display_p3.substr(0, 100)).linear.values,
                plain.linear.values);
    }
}

TEST(Photo, FloatsAreLinear) {
  TemporaryFolder folder;
  write_exr(folder / "p.exr", {{"rgb", {"R", "G", "B"}, ExrPart::Type::kFloat, block_picture(3)}}, {});
  EXPECT_FLOAT_EQ(read_photo(folder / "p.exr").linear.pixel(25, 25)[0], 0.8f);
}

TEST(Photo, RefusesWhatIsWrongInWords) {
  TemporaryFolder folder;
  write_png(folder / "tiny.png", Image(1, 1, 3));
  expect_message(input_error_of([&] { read_photo(folder / "tiny.png"); }), {"tiny.png", "1 x 1"});
  expect_message(input_error_of([&] { read_photo(folder / "none.png"); }), {"none.png", "no such file"});
  Image bad = block_picture(3);
  bad.pixel(7, 9)[1] = std::nanf("");
  write_exr(folder / "nan.exr", {{"rgb", {"R", "G", "B"}, ExrPart::Type::kFloat, bad}}, {});
  expect_message(input_error_of([&] { read_photo(folder / "nan.exr"); }), {"nan.exr", "(7, 9)", "NaN"});
}

TEST(Mask, ComesFromAlphaOrFileAndMustCoverSomethingButNotAll) {
  TemporaryFolder folder;
  write_png(folder / "rgba.png", block_picture(4));
  write_png(folder / "rgb.png", block_picture(3));
  write_png(folder / "mask.png", block_mask());
  write_png(folder / "small.png", Image(30, 32, 1));
  write_png(folder / "black.png", Image(60, 64, 1));
  Image white(60, 64, 1);
  std::fill(white.values.begin(), white.values.end(), 1.0f);
  write_png(folder / "white.png", white);
  const Photo cut = read_photo(folder / "rgba.png"), whole = read_photo(folder / "rgb.png");
  EXPECT_EQ(mask_of(cut, "rgba.png", {}).values, block_mask().values);
  EXPECT_EQ(mask_of(whole, "rgb.png", folder / "mask.png").values, block_mask().values);
  expect_message(input_error_of([&] { mask_of(whole, "rgb.png", {}); }), {"rgb.png", "no alpha", "--mask"});
  expect_message(input_error_of([&] { mask_of(whole, "rgb.png", folder / "small.png"); }),
                 {"30 x 32", "60 x 64"});
  expect_message(input_error_of([&] { mask_of(whole, "rgb.png", folder / "black.png"); }),
                 {"covers nothing"});
  expect_message(input_error_of([&] { mask_of(whole, "rgb.png", folder / "white.png"); }),
                 {"covers everything"});
}

TEST(Mask, AnAlphaThatIsOneEverywhereSaysNothing) {
  TemporaryFolder folder;
  write_png(folder / "rgb.png", block_picture(3));
  const Photo photo = read_photo(folder / "rgb.png");
  for (const int channels : {2, 4}) {
    Image mask(60, 64, channels);
    for (int y = 0; y < 64; ++y)
      for (int x = 0; x < 60; ++x)
        for (int c = 0; c < channels; ++c)
          mask.pixel(x, y)[c] = c == channels - 1 ? 1 : *block_mask().pixel(x, y);
    write_with(folder / "opaque.png", mask, OIIO::TypeDesc::UINT8, [&](OIIO::ImageSpec& spec) {
      spec.attribute("oiio:UnassociatedAlpha", 1);
      if (channels == 2) spec.channelnames = {"Y", "A"}, spec.alpha_channel = 1;
    });
    EXPECT_EQ(mask_of(photo, "rgb.png", folder / "opaque.png").values, block_mask().values) << channels;
  }
}

TEST(Mask, InvertedIsSaidInWords) {
  TemporaryFolder folder;
  write_png(folder / "rgb.png", block_picture(3));
  const Photo photo = read_photo(folder / "rgb.png");
  Image inverted = block_mask();
  for (float& value : inverted.values) value = 1 - value;
  write_png(folder / "inverted.png", inverted);
  expect_message(input_error_of([&] { mask_of(photo, "rgb.png", folder / "inverted.png"); }),
                 {"inverted.png", "it is inverted", "white on the person"});
}

TEST(Crop, IsASquareAroundTheSubjectAndMayLeaveThePhoto) {
  const Crop crop = crop_around(block_mask());
  EXPECT_DOUBLE_EQ(crop.side_px, 44);
  EXPECT_DOUBLE_EQ(crop.left_px + crop.side_px / 2, 30);
  EXPECT_DOUBLE_EQ(crop.top_px + crop.side_px / 2, 30);
  Image edge(60, 64, 1);
  for (int y = 0; y < 64; ++y) edge.pixel(0, y)[0] = 1;
  EXPECT_LT(crop_around(edge).left_px, 0);
}

TEST(Foreground, KeepsColourAndAreaAtAnySize) {
  Photo photo;
  photo.linear = Image(60, 64, 3);
  for (float& v : photo.linear.values) v = 0.5f;
  const Image mask = block_mask();
  for (const int size : {16, 32, 176}) {
    const Foreground f = foreground_of(photo, mask, crop_around(mask), size);
    // The covered share of the crop: 20 x 40 of 44 x 44.
    EXPECT_NEAR(f.mask.mean().item<double>(), 800.0 / (44 * 44), 2e-3) << size;
    EXPECT_EQ(f.input[0][0][0][0].item<float>(), -1) << size;
    const float middle = f.input[0][1][size / 2][size / 2].item<float>();
    EXPECT_NEAR(middle, 2 * linear_to_srgb(0.5f) - 1, 1e-4) << size;
  }
}

TEST(Foreground, TenThousandPixelsASideAreTaken) {
  Photo photo;
  photo.linear = Image(10000, 40, 3);
  Image mask(10000, 40, 1);
  for (int x = 100; x < 9900; ++x) mask.pixel(x, 20)[0] = 1;
  const Foreground f = foreground_of(photo, mask, crop_around(mask), 32);
  EXPECT_TRUE(torch::isfinite(f.input).all().item<bool>());
}

}  // namespace
}  // namespace ohb
