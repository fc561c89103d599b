// Pictures as people bring them: encodings, orientations and windows that a reader must see, and files that
// were never what their names say.
#include <cmath>

#include "dataset/model/colour.h"
#include "dataset/model/environment.h"
#include "dataset/model/foreign_content.h"
#include "dataset/model/image_place.h"
#include "dataset/model/regions.h"
#include "dataset/model/scan.h"
#include "dataset/model/xml_document.h"
#include "tests/support/foreign_files.h"
#include "tests/support/scan_files.h"
#include "tests/support/shared_data.h"
#include "tests/support/test_files.h"

namespace ohb {
namespace {

Image grey(int width, int height, float value, int channels = 3) {
  Image image(width, height, channels);
  std::fill(image.values.begin(), image.values.end(), value);
  return image;
}

TEST(FaultsPictures, IntegerEnvironmentsAreDecodedAndSaidToHoldNoSun) {
  const TemporaryFolder folder;
  const float stored = 128.0f / 255;
  const OIIO::TypeDesc bytes = OIIO::TypeDesc::UINT8, words = OIIO::TypeDesc::UINT16;
  for (const auto& [name, type] : {std::pair("e.png", bytes),
                                   {"e.jpg", bytes},
                                   {"e.tif", bytes},
                                   {"e16.png", words},
                                   {"e16.tif", words}}) {
    SCOPED_TRACE(name);
    const Environment environment =
        read_environment(write_picture_with(folder / name, grey(16, 8, stored), type));
    EXPECT_NEAR(environment.radiance.pixel(5, 5)[1], srgb_to_linear(stored), 0.004f);
    EXPECT_NEAR(environment.radiance.pixel(5, 5)[1], 0.216f, 0.006f);
    ASSERT_EQ(environment.warnings.size(), 1u);
    expect_message(environment.warnings[0], {type == bytes ? "8-bit" : "16-bit", "sRGB", "no sun"});
  }
  const Environment says_linear = read_environment(
      write_picture_with(folder / "l.png", grey(16, 8, stored), bytes,
                         [](OIIO::ImageSpec& spec) { spec.attribute("oiio:ColorSpace", "Linear"); }));
  EXPECT_NEAR(says_linear.radiance.pixel(5, 5)[1], stored, 1e-6f);
  expect_message(says_linear.warnings.at(0), {"linear as it says itself", "no sun"});
  const Environment floats =
      read_environment(write_picture_with(folder / "f.exr", grey(16, 8, stored), OIIO::TypeDesc::FLOAT));
  EXPECT_EQ(floats.radiance.pixel(5, 5)[1], stored);
  EXPECT_TRUE(floats.warnings.empty());
}

TEST(FaultsPictures, GreyAndTransparentEnvironments) {
  const TemporaryFolder folder;
  const Environment one =
      read_environment(write_picture_with(folder / "y.exr", grey(16, 8, 0.25f, 1), OIIO::TypeDesc::HALF));
  EXPECT_EQ(one.radiance.pixel(3, 3)[2], 0.25f);
  const Environment four = read_environment(
      write_picture_with(folder / "rgba.png", grey(16, 8, 0.5f, 4), OIIO::TypeDesc::UINT8,
                         [](OIIO::ImageSpec& spec) { spec.attribute("oiio:UnassociatedAlpha", 1); }));
  EXPECT_NEAR(four.radiance.pixel(3, 3)[2], srgb_to_linear(0.5f), 0.004f);
}

TEST(FaultsPictures, AnEnvironmentIsTurnedByItsExifOrientation) {
  const TemporaryFolder folder;
  Image stored = grey(16, 8, 0.1f);
  stored.pixel(0, 0)[0] = 1;
  const auto file = write_picture_with(folder / "turned.tif", stored, OIIO::TypeDesc::UINT8,
                                       [](OIIO::ImageSpec& spec) { spec.attribute("Orientation", 3); });
  EXPECT_EQ(read_environment(file).radiance.pixel(15, 7)[0], 1);
}

TEST(FaultsPictures, AllEightOrientationsOfRadiancePicturesAreTurned) {
  const TemporaryFolder folder;
  const auto red = [](int x, int y) { return static_cast<uint8_t>(40 + 10 * x + 50 * y); };
  for (const std::string y : {"-Y", "+Y"})
    for (const std::string x : {"+X", "-X"})
      for (const bool rows_first : {true, false}) {
        const std::string bytes = radiance_picture(rows_first ? y : x, rows_first ? x : y, 4, 2, red);
        SCOPED_TRACE((rows_first ? y : x) + " " + (rows_first ? x : y));
        ImageFileInfo info;
        const auto file = write_bytes(folder / "e.hdr", bytes);
        const Image image = read_image(file, &info);
        ASSERT_EQ(image.width_px, 4);
        ASSERT_EQ(image.height_px, 2);
        for (int row = 0; row < 2; ++row)
          for (int column = 0; column < 4; ++column)
            EXPECT_NEAR(image.pixel(column, row)[0], red(column, row) + 0.5f, 0.51f);
        EXPECT_EQ(info.orientation, 1) << "it is turned already";
        EXPECT_EQ(probe_image(file).width_px, 4);
        EXPECT_EQ(read_image_bytes(bytes, "embedded").values, image.values);
        EXPECT_EQ(read_environment(file).radiance.pixel(3, 1)[0], image.pixel(3, 1)[0]);
      }
}

TEST(FaultsPictures, RadiancePicturesThatCannotBeTurnedAreRefused) {
  const TemporaryFolder folder;
  const auto red = [](int, int) { return uint8_t{90}; };
  std::string xyz = radiance_picture("-Y", "+X", 4, 2, red);
  xyz.replace(xyz.find("rgbe"), 4, "xyze");
  expect_message(input_error_of([&] { read_image(write_bytes(folder / "x.hdr", xyz)); }), {"x.hdr"});
  std::string odd = radiance_picture("-Y", "+X", 4, 2, red);
  odd.replace(odd.find("+X"), 2, "+Z");
  expect_message(input_error_of([&] { read_image(write_bytes(folder / "z.hdr", odd)); }), {"z.hdr"});
}

struct Window {
  int x, y, width, height;
};

/// 1 inside the data window, placed in a display window of 20 x 10 that begins at `origin`.
std::filesystem::path windowed(const std::filesystem::path& file, const Window& window, OIIO::TypeDesc type,
                               int origin = 0, int tile = 0) {
  const auto [x, y, width, height] = window;
  return write_picture_with(file, grey(width, height, 1), type, [=](OIIO::ImageSpec& spec) {
    spec.x = origin + x, spec.y = origin + y;
    spec.full_x = spec.full_y = origin;
    spec.full_width = 20, spec.full_height = 10;
    if (tile) spec.tile_width = spec.tile_height = tile;
  });
}

TEST(FaultsPictures, AnExrsDataWindowIsPlacedInItsDisplayWindow) {
  const TemporaryFolder folder;
  struct Window {
    int x, y, width, height;
  };
  for (const Window& w :
       {Window{5, 2, 4, 3}, {0, 0, 20, 10}, {-3, -2, 30, 20}, {15, 6, 9, 9}, {-4, 0, 8, 10}})
    for (const OIIO::TypeDesc type : {OIIO::TypeDesc::HALF, OIIO::TypeDesc::FLOAT})
      for (const int origin : {0, -7})
        for (const int tile : {0, 16}) {
          SCOPED_TRACE(std::to_string(w.x) + ", " + std::to_string(w.y) + ", tile " + std::to_string(tile));
          const auto file = windowed(folder / "w.exr", {w.x, w.y, w.width, w.height}, type, origin, tile);
          const Image image = read_image(file);
          ASSERT_EQ(image.width_px, 20);
          ASSERT_EQ(image.height_px, 10);
          EXPECT_EQ(probe_image(file).width_px, 20);
          EXPECT_EQ(read_exr_image(file).values, image.values);
          EXPECT_EQ(read_exr(file).at(0).image.values, image.values);
          for (int y = 0; y < 10; ++y)
            for (int x = 0; x < 20; ++x) {
              const bool is_inside = x >= w.x && x < w.x + w.width && y >= w.y && y < w.y + w.height;
              ASSERT_EQ(image.pixel(x, y)[1], is_inside ? 1 : 0) << x << ", " << y;
            }
        }
  EXPECT_EQ(read_environment(windowed(folder / "e.exr", {5, 2, 4, 3}, OIIO::TypeDesc::HALF))
                .radiance.pixel(6, 3)[0],
            1);
}

TEST(FaultsPictures, WindowsThatShowNothingOrAreHugeAreRefused) {
  const TemporaryFolder folder;
  expect_message(input_error_of([&] {
                   read_image(windowed(folder / "out.exr", {40, 0, 4, 4}, OIIO::TypeDesc::HALF));
                 }),
                 {"out.exr", "outside its display window"});
  const auto huge =
      write_picture_with(folder / "huge.exr", grey(4, 4, 1), OIIO::TypeDesc::HALF,
                         [](OIIO::ImageSpec& spec) { spec.full_width = spec.full_height = 30000; });
  expect_message(input_error_of([&] { read_image(huge); }), {"huge.exr", "display window is 30000 x 30000"});
  expect_message(input_error_of([&] { probe_image(huge); }), {"display window"});
}

/// The place of a page is no window: GIMP and scanners write it.
TEST(FaultsPictures, PositionsOfPagesDoNotMoveAPicture) {
  const TemporaryFolder folder;
  for (const char* name : {"p.png", "p.tif"}) {
    const auto file = write_picture_with(folder / name, grey(8, 8, 1), OIIO::TypeDesc::UINT8,
                                         [](OIIO::ImageSpec& spec) { spec.x = 3, spec.y = 2; });
    EXPECT_EQ(read_image(file).values, grey(8, 8, 1).values) << name;
  }
}

TEST(FaultsPictures, FilesThatWereNeverDownloadedAreNamed) {
  const TemporaryFolder folder;
  const std::string lfs =
      "version https://git-lfs.github.com/spec/v1\noid "
      "sha256:4d7a214614ab2935c943f9e0ff69d22eadbb8f32b1258daaa5"
      "e2ca24d17e2393\nsize 12345\n";
  for (const std::string name : {"a.glb", "a.gltf", "a.obj", "a.fbx"})
    expect_message(input_error_of([&] { read_scan(write_bytes(folder / name, lfs)); }),
                   {name, "Git LFS pointer", "git lfs pull"});
  for (const std::string name : {"p.png", "p.jpg", "p.exr", "p.hdr"})
    expect_message(input_error_of([&] { read_environment(write_bytes(folder / name, lfs)); }),
                   {name, "Git LFS pointer"});
  write_bytes(folder / "m.mtl", lfs);
  expect_message(input_error_of([&] {
                   read_scan(write_bytes(folder / "s.obj", "mtllib m.mtl\n" + std::string(kQuadObj)));
                 }),
                 {"m.mtl", "Git LFS pointer"});
  expect_message(input_error_of([&] { read_face_classes(write_bytes(folder / "f.txt", lfs), 3, {}); }),
                 {"f.txt", "Git LFS pointer"});
  expect_message(input_error_of([&] { XmlDocument(write_bytes(folder / "x.xml", lfs), "model"); }),
                 {"x.xml", "Git LFS pointer"});
  expect_message(input_error_of([&] {
                   read_scan(write_bytes(folder / "annex.glb", "/annex/objects/SHA256E-s5--ab.glb\n"));
                 }),
                 {"git-annex", "git annex get"});
}

TEST(FaultsPictures, WebPagesArchivesAndOtherFormatsAreNamed) {
  const TemporaryFolder folder;
  const auto scan_error = [&](const std::string& name, const std::string& bytes) {
    return input_error_of([&] { read_scan(write_bytes(folder / name, bytes)); });
  };
  expect_message(scan_error("a.obj", "<!DOCTYPE html>\n<html><body>404</body></html>\n"),
                 {"web page", "download"});
  expect_message(scan_error("a.glb", "\n <HTML><head>"), {"web page"});
  expect_message(scan_error("a.fbx", "<?xml version='1.0'?><Error><Code>AccessDenied</Code></Error>"),
                 {"web page or a server's error"});
  expect_message(scan_error("b.obj", std::string("PK\3\4\x14\0\0\0", 8)), {"zip archive", "unpack"});
  expect_message(scan_error("b.glb", "\x1f\x8b\x08"), {"gzip archive"});
  expect_message(scan_error("c.obj", glb_of(quad_glb_json(), quad_glb_binary())), {"binary glTF", ".glb"});
  expect_message(scan_error("d.obj", "ply\nformat ascii 1.0\n"), {"PLY"});
  expect_message(scan_error("e.obj", "../models/person.obj"), {"person.obj", "link"});
  expect_message(scan_error("f.obj", ""), {"empty (0 bytes)"});
  const auto picture_error = [&](const std::string& name, const std::string& bytes) {
    return input_error_of([&] { read_image(write_bytes(folder / name, bytes)); });
  };
  expect_message(picture_error("p.png", "<html>"), {"web page"});
  expect_message(picture_error("q.png", "textures/q.png"), {"textures/q.png", "link"});
  expect_message(picture_error("r.png", "GIF89a"), {"GIF", "PNG"});
}

// The files of ../shared/data/faults, where they are present.

TEST(FaultsPictures, SharedEnvironments) {
  OHB_SHARED_DATA_OR_SKIP(faults, "faults");
  const auto png = read_environment(faults / "02-env-8bit-taken-as-linear/c128.png");
  EXPECT_NEAR(png.radiance.values[0], 0.2159f, 1e-3f);
  EXPECT_EQ(png.warnings.size(), 1u);
  const auto reference = read_image(faults / "03-hdr-orientation-ignored/ref.exr");
  for (const char* name : {"plain.hdr", "plusY.hdr"}) {
    const auto turned = read_environment(faults / "03-hdr-orientation-ignored" / name);
    ASSERT_EQ(turned.radiance.values.size(), reference.values.size());
    double worst = 0;
    for (size_t i = 0; i < reference.values.size(); ++i)
      worst = std::max(worst, std::abs(static_cast<double>(turned.radiance.values[i]) - reference.values[i]) /
                                  (0.05 + reference.values[i]));
    EXPECT_LT(worst, 0.05) << name;
  }
}

TEST(FaultsPictures, SharedWindowAndPointer) {
  OHB_SHARED_DATA_OR_SKIP(faults, "faults");
  const Scan scan = read_scan(faults / "21-exr-cropped-data-window/exr_window/a.obj");
  const Image picture = read_image(scan.materials.at(0).diffuse);
  EXPECT_EQ(picture.width_px, 256);
  EXPECT_EQ(picture.height_px, 256);
  for (int y = 0; y < 256; y += 15) EXPECT_EQ(picture.pixel(200, y)[0], 0) << "nothing is stored there";
  expect_message(input_error_of([&] { read_scan(faults / "23-lfs-pointer/lfs.glb"); }),
                 {"Git LFS pointer", "git lfs pull"});
}

}  // namespace
}  // namespace ohb
