// Texture transforms and wrapping: what a UV shows stays the same, whichever of UVs and pictures is moved.
#include <gtest/gtest.h>

#include <cmath>

#include "dataset/model/error.h"
#include "dataset/model/scan_readers.h"
#include "tests/support/test_files.h"

namespace ohb {
namespace {

/// Every pixel has another value.
Image numbered_picture(int width, int height) {
  Image picture(width, height, 3);
  for (size_t i = 0; i < picture.values.size(); ++i)
    picture.values[i] = static_cast<float>(i * 5 % 251) / 255.0f;
  return picture;
}

/// One triangle that holds the given UVs, with a picture and what it shows.
struct Sheet {
  TemporaryFolder folder;
  Scan scan;
  Image stored = numbered_picture(8, 4);

  explicit Sheet(std::vector<Vec2f> uvs) {
    write_png(folder / "p.png", stored);
    scan.file = folder / "a.obj";
    scan.uvs = std::move(uvs);
    scan.positions.assign(3, {});
    scan.materials.resize(1);
    scan.materials[0].name = "m";
    scan.materials[0].diffuse = {folder / "p.png", nullptr};
    scan.groups = {"g"};
    begin_face(scan, 0, 0);
    for (uint32_t i = 0; i < 3; ++i) scan.corners.push_back({i, i});
    close_faces(scan);
  }
  ScanPicture& diffuse() { return scan.materials[0].diffuse; }
};

int wrapped_index(double place, int size, Wrap wrap) {
  if (wrap == Wrap::kClamp) place = std::min(std::max(place, 0.0), 0.999999);
  if (wrap == Wrap::kMirror) {
    place = std::fmod(std::fmod(place, 2) + 2, 2);
    if (place >= 1) place = 2 - place;
  }
  place -= std::floor(place);
  return std::min(static_cast<int>(place * size), size - 1);
}

/// The pixel that a UV shows through a view, by the definition.
const float* shown(const Image& picture, const PictureView& v, double x, double y) {
  const double u = v.uu * x + v.uv * y + v.u0, w = v.vu * x + v.vv * y + v.v0;
  const int column = wrapped_index(u, picture.width_px, v.wrap_u);
  const int row = picture.height_px - 1 - wrapped_index(w, picture.height_px, v.wrap_v);
  return picture.pixel(column, row);
}

/// At middles of pixels all over the triangle's box: the same pixel before and after settling.
void expect_same_look(Sheet& sheet) {
  const PictureView view = sheet.diffuse().view;
  const std::vector<Vec2f> before = sheet.scan.uvs;
  settle_pictures(sheet.scan);
  const Image after = read_image(sheet.diffuse());
  const ImageFileInfo probed = probe_image(sheet.diffuse());
  EXPECT_EQ(after.width_px, probed.width_px);
  EXPECT_EQ(after.height_px, probed.height_px);
  const PictureView plain;
  const auto corner = [&](int i) { return sheet.scan.uvs[sheet.scan.corners[static_cast<size_t>(i)].uv]; };
  for (int i = 0; i < 40; ++i)
    for (int j = 0; j < 40; ++j) {
      const double s = (i + 0.37) / 40, t = (j + 0.21) / 40;
      if (s + t > 1) continue;
      const auto at = [&](Vec2f a, Vec2f b, Vec2f c) {
        return std::pair(a.x + s * (b.x - a.x) + t * (c.x - a.x), a.y + s * (b.y - a.y) + t * (c.y - a.y));
      };
      const auto [u, v] = at(before[0], before[1], before[2]);
      const auto [new_u, new_v] = at(corner(0), corner(1), corner(2));
      const float *was = shown(sheet.stored, view, u, v), *is = shown(after, plain, new_u, new_v);
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(was[c], is[c], 1e-6) << u << " " << v;
    }
}

TEST(ScanViews, TransformsAreMovedIntoTheUvs) {
  Sheet sheet({{0, 0}, {1, 0}, {0, 1}});
  sheet.diffuse().view.uu = 2;
  sheet.diffuse().view.vv = 0.5;
  sheet.diffuse().view.u0 = 0.25;
  expect_same_look(sheet);
  EXPECT_TRUE(sheet.diffuse().view.is_plain());
  EXPECT_FLOAT_EQ(sheet.scan.uvs[1].x, 2.25f);
  EXPECT_EQ(sheet.scan.notes.size(), 1u);
}

TEST(ScanViews, RotationsAreMovedIntoTheUvs) {
  Sheet sheet({{0, 0}, {1, 0}, {0, 1}});
  PictureView& view = sheet.diffuse().view;
  view.uu = view.vv = std::cos(0.4);
  view.uv = -(view.vu = std::sin(0.4));
  expect_same_look(sheet);
}

TEST(ScanViews, MirroredPicturesHaveAPeriodOfTwo) {
  Sheet sheet({{-3.5f, 0.5f}, {4, 0.25f}, {0, 6}});
  sheet.diffuse().view.wrap_u = sheet.diffuse().view.wrap_v = Wrap::kMirror;
  expect_same_look(sheet);
  EXPECT_EQ(probe_image(sheet.diffuse()).width_px, 16);
}

TEST(ScanViews, ClampedPicturesReachAsFarAsTheirUvs) {
  Sheet sheet({{-1.5f, 0.5f}, {2, 0.25f}, {0, 1.75f}});
  sheet.diffuse().view.wrap_u = sheet.diffuse().view.wrap_v = Wrap::kClamp;
  expect_same_look(sheet);
  EXPECT_EQ(probe_image(sheet.diffuse()).width_px, 32);
}

TEST(ScanViews, OneAxisMirroredTheOtherClampedAndScaled) {
  Sheet sheet({{0, 0}, {1, 0}, {0, 1}});
  PictureView& view = sheet.diffuse().view;
  view.uu = view.vv = 3;
  view.wrap_u = Wrap::kMirror;
  view.wrap_v = Wrap::kClamp;
  expect_same_look(sheet);
}

TEST(ScanViews, WrappingThatNothingReachesChangesNothing) {
  Sheet sheet({{0, 0}, {1, 0}, {0, 1}});
  sheet.diffuse().view.wrap_u = sheet.diffuse().view.wrap_v = Wrap::kClamp;
  settle_pictures(sheet.scan);
  EXPECT_TRUE(sheet.diffuse().view.is_plain());
  EXPECT_TRUE(sheet.scan.notes.empty());
}

TEST(ScanViews, PicturesOfOtherTransformsAreLookedUp) {
  Sheet sheet({{0, 0}, {1, 0}, {0, 1}});
  ScanPicture& alpha = sheet.scan.materials[0].alpha = sheet.diffuse();
  alpha.view.uu = alpha.view.vv = 2;
  const PictureView view = alpha.view;
  settle_pictures(sheet.scan);
  const Image seen = read_image(alpha);
  ASSERT_EQ(seen.width_px, 16);
  for (int x = 0; x < 16; ++x)
    for (int y = 0; y < 8; ++y)
      EXPECT_NEAR(*seen.pixel(x, y), *shown(sheet.stored, view, (x + 0.5) / 16, 1 - (y + 0.5) / 8), 1e-6);
}

TEST(ScanViews, UvsOfOtherMaterialsStay) {
  Sheet sheet({{0, 0}, {1, 0}, {0, 1}});
  sheet.scan.face_begin.pop_back();
  begin_face(sheet.scan, 1, 0);
  for (uint32_t i = 0; i < 3; ++i) sheet.scan.corners.push_back({i, i});
  close_faces(sheet.scan);
  sheet.scan.materials.resize(2);
  sheet.diffuse().view.uu = 2;
  settle_pictures(sheet.scan);
  EXPECT_EQ(sheet.scan.uvs[sheet.scan.corners[1].uv].x, 2);
  EXPECT_EQ(sheet.scan.uvs[sheet.scan.corners[4].uv].x, 1);
}

TEST(ScanViews, BadViewsAreRefused) {
  Sheet sheet({{0, 0}, {1, 0}, {0, 1}});
  sheet.diffuse().view.u0 = NAN;
  EXPECT_THROW(settle_pictures(sheet.scan), InputError);
  Sheet far({{0, 0}, {1000, 0}, {0, 1}});
  far.diffuse().view.wrap_u = Wrap::kClamp;
  EXPECT_THROW(settle_pictures(far.scan), InputError);
}

TEST(ScanPositions, FarAwayScansAreCentredInDouble) {
  Scan scan;
  store_positions(scan, {{456789.001, 10, 5432100.25}, {456790.002, 11.8, 5432101.75}});
  ASSERT_TRUE(scan.removed_offset);
  EXPECT_EQ(scan.notes.size(), 1u);
  EXPECT_NEAR(scan.positions[1].x - scan.positions[0].x, 1.001, 1e-6);
  EXPECT_NEAR(scan.positions[0].z + scan.removed_offset->z, 5432100.25, 1e-6);
}

TEST(ScanPositions, ScansNearTheOriginStayBitForBit) {
  Scan scan;
  store_positions(scan, {{50.1f, 0, 0}, {51.3f, 0, 1.7f}});
  EXPECT_FALSE(scan.removed_offset);
  EXPECT_EQ(scan.positions[0].x, 50.1f);
}

}  // namespace
}  // namespace ohb
