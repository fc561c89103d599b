#include "bake/bake.h"

#include <tbb/global_control.h>

#include <cmath>

#include "dataset/model/atomic_file.h"
#include "dataset/model/colour.h"
#include "dataset/surface/texel_coverage.h"
#include "tests/support/test_files.h"

namespace ohb {
using namespace bake;
using namespace surface;
namespace {

constexpr MaterialTable kTable = {
    {{0.184f, 0.4f, 0.08f}, {0.239f, 0.5f, 0}, {0.263f, 0.85f, 0}, {0.224f, 0.25f, 0}}};

/// Quads given by 4 corners of position and UV each; one material a quad if `separate`.
struct Quad {
  Vec3f position[4];
  Vec2f uv[4];
};

Scan scan_of(const std::vector<Quad>& quads, bool separate = false) {
  Scan scan;
  scan.file = "quads.obj";
  scan.groups = {"all"};
  scan.face_begin = {0};
  for (size_t q = 0; q < quads.size(); ++q) {
    for (int c = 0; c < 4; ++c) {
      const uint32_t index = static_cast<uint32_t>(scan.positions.size());
      scan.positions.push_back(quads[q].position[c]);
      scan.uvs.push_back(quads[q].uv[c]);
      scan.corners.push_back({index, index});
    }
    scan.face_begin.push_back(static_cast<uint32_t>(scan.corners.size()));
    scan.face_material.push_back(static_cast<uint16_t>(separate ? q : 0));
    scan.face_group.push_back(0);
  }
  scan.materials.resize(separate ? quads.size() : 1);
  for (size_t m = 0; m < scan.materials.size(); ++m) scan.materials[m].name = "material" + std::to_string(m);
  return scan;
}

Regions regions_of(const std::vector<uint8_t>& classes) {
  return {classes, std::string(64, '0')};
}

/// z = 2 x + 3 y + 5 over [0,1]^2, the UVs turned by `quarter_turns` about the middle and mirrored on demand.
Quad tilted_plane(int quarter_turns, bool mirrored) {
  Quad quad{};
  const Vec2f square[4] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  for (int c = 0; c < 4; ++c) {
    const Vec2f p = square[c];
    quad.position[c] = {p.x, p.y, 2 * p.x + 3 * p.y + 5};
    Vec2f uv = p;
    for (int i = 0; i < quarter_turns; ++i) uv = {1 - uv.y, uv.x};
    quad.uv[c] = mirrored ? Vec2f{1 - uv.x, uv.y} : uv;
  }
  return quad;
}

TEST(Bake, DisplacementOfAPlaneWhateverTheTurnOfItsChart) {
  for (int turns = 0; turns < 4; ++turns)
    for (bool mirrored : {false, true}) {
      BakeOptions options;
      options.size_px = 24;
      options.unit_cm = 2;
      BakeReport report;
      const Model model =
          bake_model(scan_of({tilted_plane(turns, mirrored)}), regions_of({kSkin}), kTable, options, &report);
      const TextureSet& set = model.sets[0];
      for (int row = 0; row < 24; ++row)
        for (int x = 0; x < 24; ++x) {
          Vec2f uv{(static_cast<float>(x) + 0.5f) / 24, 1 - (static_cast<float>(row) + 0.5f) / 24};
          if (mirrored) uv.x = 1 - uv.x;
          for (int i = 0; i < turns; ++i) uv = {uv.y, 1 - uv.x};
          // Centred: z runs from 5 to 10 in the source, so from -5 to 5 cm here.
          EXPECT_NEAR(*set.displacement.pixel(x, row), 2 * (2 * uv.x + 3 * uv.y - 2.5f), 1e-5f);
          EXPECT_EQ(*set.valid.pixel(x, row), 1.0f);
        }
      EXPECT_EQ(report.sets[0].centre_texels, 24u * 24u);
      EXPECT_EQ(report.sets[0].overlapping_texels, 0u);
      EXPECT_NEAR(report.sets[0].mirrored_area_cm2, mirrored ? report.sets[0].area_cm2 : 0, 1e-6);
    }
}

TEST(Bake, CanonicalFrameIsCentredOnTheGroundAndRecorded) {
  Quad quad = tilted_plane(0, false);
  for (Vec3f& p : quad.position) p = p + Vec3f{10, -7, 100};
  Scan scan = scan_of({quad});
  scan.positions.push_back({1e6f, 1e6f, 1e6f});  // used by no face
  const CanonicalMesh mesh = canonical_mesh(scan, regions_of({kSkin}), 2.5);
  const Bounds bounds = bounds_of(mesh.model.positions_cm);
  EXPECT_NEAR(bounds.low.x, -1.25f, 1e-5f);
  EXPECT_NEAR(bounds.high.x, 1.25f, 1e-5f);
  EXPECT_EQ(bounds.low.y, 0.0f);
  EXPECT_NEAR(bounds.low.z, -bounds.high.z, 1e-4f);
  EXPECT_EQ(mesh.model.positions_cm.size(), 4u);
  EXPECT_EQ(mesh.model.source_unit_cm, 2.5);
  EXPECT_FLOAT_EQ(mesh.model.source_shift_cm.y, 17.5f);
  EXPECT_FLOAT_EQ(mesh.model.source_shift_cm.x, -26.25f);
}

/// Two quads side by side in one map with a gap between them.
std::vector<Quad> two_charts() {
  Quad left{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}},
            {{0.1f, 0.1f}, {0.4f, 0.1f}, {0.4f, 0.9f}, {0.1f, 0.9f}}};
  Quad right{{{2, 0, 0}, {3, 0, 0}, {3, 1, 0}, {2, 1, 0}},
             {{0.6f, 0.1f}, {0.9f, 0.1f}, {0.9f, 0.9f}, {0.6f, 0.9f}}};
  return {left, right};
}

TEST(Bake, ClassesBecomeTheTablesValues) {
  BakeOptions options;
  options.size_px = 64;
  const Model model = bake_model(scan_of(two_charts()), regions_of({kHair, kLeather}), kTable, options);
  const TextureSet& set = model.sets[0];
  EXPECT_EQ(*set.roughness.pixel(16, 32), 0.5f);
  EXPECT_EQ(*set.specular.pixel(16, 32), 0.239f);
  EXPECT_EQ(*set.roughness.pixel(48, 32), 0.25f);
  EXPECT_EQ(*set.sss.pixel(48, 32), 0.0f);
  // At the border of a chart the texels that bilinear lookups read are the chart's own.
  for (int x = 6; x <= 25; ++x) EXPECT_EQ(*set.roughness.pixel(x, 32), 0.5f) << x;
  EXPECT_EQ(*set.valid.pixel(32, 32), 0.5f);
  EXPECT_GT(*set.roughness.pixel(32, 32), 0.25f);
  EXPECT_LT(*set.roughness.pixel(32, 32), 0.5f);
  EXPECT_EQ(model.triangles[0].material_class, kHair);
  EXPECT_EQ(model.triangles[3].source_face, 1u);
}

TEST(Bake, SharesOfClassesMix) {
  const ClassMaterial mixed = mix_classes(kTable, {0.25f, 0, 0.75f, 0});
  EXPECT_FLOAT_EQ(mixed.roughness, 0.25f * 0.4f + 0.75f * 0.85f);
  EXPECT_FLOAT_EQ(mixed.sss, 0.02f);
}

/// A scan of one quad over the whole map, with a picture.
struct PicturedQuad {
  TemporaryFolder folder;
  Scan scan = scan_of({tilted_plane(0, false)});
  explicit PicturedQuad(const Image& picture) {
    write_png(folder / "p.png", picture);
    scan.materials[0].diffuse = {folder / "p.png", nullptr};
  }
};

Image pattern(int width, int height, int channels) {
  Image image(width, height, channels);
  for (size_t i = 0; i < image.values.size(); ++i) image.values[i] = static_cast<float>(i * 53 % 256) / 255;
  return image;
}

TEST(Bake, AlbedoOfEqualSizeIsAnExactLinearCopy) {
  const Image picture = pattern(40, 20, 3);
  const PicturedQuad quad(picture);
  const Model model = bake_model(quad.scan, regions_of({kSkin}), kTable, {});
  const Image& albedo = model.sets[0].albedo;
  ASSERT_EQ(albedo.width_px, 40);
  ASSERT_EQ(albedo.height_px, 20);
  for (size_t i = 0; i < picture.values.size(); ++i)
    EXPECT_NEAR(albedo.values[i], srgb_to_linear(picture.values[i]), 1e-6f);
}

TEST(Bake, SmallerMapsAverageInLinear) {
  Image picture(2, 2, 3);
  for (int i = 0; i < 12; ++i) picture.values[i] = i < 6 ? 1.0f : 0.0f;
  const PicturedQuad quad(picture);
  BakeOptions options;
  options.size_px = 1;
  const Model model = bake_model(quad.scan, regions_of({kSkin}), kTable, options);
  EXPECT_NEAR(model.sets[0].albedo.values[0], 0.5f, 1e-6f);  // in sRGB values it would be 0.214
}

TEST(Bake, SmallerMapsDoNotMixInTheBackgroundOfThePicture) {
  Scan scan = scan_of(two_charts());
  const TemporaryFolder folder;
  Image picture(64, 64, 3);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) {
      // The texels that lookups into the charts read are grey, the background is a poisonous green.
      const bool is_chart = y >= 5 && y <= 58 && ((x >= 5 && x <= 26) || (x >= 37 && x <= 58));
      picture.pixel(x, y)[1] = is_chart ? 0.5f : 1.0f;
      picture.pixel(x, y)[0] = picture.pixel(x, y)[2] = is_chart ? 0.5f : 0.0f;
    }
  write_png(folder / "p.png", picture);
  scan.materials[0].diffuse = {folder / "p.png", nullptr};
  BakeOptions options;
  options.size_px = 16;
  const Model model = bake_model(scan, regions_of({kSkin, kSkin}), kTable, options);
  const float grey = srgb_to_linear(128 / 255.0f);
  for (float value : model.sets[0].albedo.values) EXPECT_NEAR(value, grey, 1e-5f);
}

TEST(Bake, FactorMultipliesThePictureOrIsTheColour) {
  PicturedQuad quad(pattern(8, 8, 3));
  quad.scan.materials[0].diffuse_factor = {0.5f, 1, 0.25f};
  Model model = bake_model(quad.scan, regions_of({kSkin}), kTable, {});
  EXPECT_NEAR(model.sets[0].albedo.values[2], 0.25f * srgb_to_linear(106 / 255.0f), 1e-6f);
  quad.scan.materials[0].diffuse = {};
  model = bake_model(quad.scan, regions_of({kSkin}), kTable, {});
  EXPECT_EQ(model.sets[0].albedo.width_px, kSizeWithoutPicture_px);
  EXPECT_EQ(model.sets[0].albedo.pixel(500, 3)[2], 0.25f);
}

TEST(Bake, AlphaIsKeptAndWeighsTheColour) {
  Image picture(2, 2, 4);
  for (int i = 0; i < 4; ++i) {
    picture.pixel(i % 2, i / 2)[0] = i == 0 ? 1.0f : 0.0f;  // one opaque red pixel amid clear black ones
    picture.pixel(i % 2, i / 2)[3] = i == 0 ? 1.0f : 0.0f;
  }
  PicturedQuad quad(picture);
  quad.scan.materials[0].alpha = quad.scan.materials[0].diffuse;
  Model model = bake_model(quad.scan, regions_of({kHair}), kTable, {});
  EXPECT_EQ(model.sets[0].alpha.values, (std::vector<float>{1, 0, 0, 0}));
  BakeOptions options;
  options.size_px = 1;
  model = bake_model(quad.scan, regions_of({kHair}), kTable, options);
  EXPECT_FLOAT_EQ(model.sets[0].alpha.values[0], 0.25f);
  EXPECT_FLOAT_EQ(model.sets[0].albedo.values[0], 1.0f);
}

TEST(Bake, ClearPixelsCountOnlyWhereThereAreNoOthers) {
  // All is clear; the texels that faces show are grey, the background is green.
  Scan scan = scan_of(two_charts());
  const TemporaryFolder folder;
  Image picture(64, 64, 4);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) {
      const bool is_chart = y >= 5 && y <= 58 && ((x >= 5 && x <= 26) || (x >= 37 && x <= 58));
      for (int c = 0; c < 3; ++c) picture.pixel(x, y)[c] = is_chart ? 0.5f : c == 1 ? 1.0f : 0.0f;
    }
  write_png(folder / "p.png", picture);
  scan.materials[0].diffuse = scan.materials[0].alpha = {folder / "p.png", nullptr};
  BakeOptions options;
  options.size_px = 16;
  const Model model = bake_model(scan, regions_of({kHair, kHair}), kTable, options);
  for (float value : model.sets[0].albedo.values) EXPECT_NEAR(value, srgb_to_linear(128 / 255.0f), 1e-5f);
}

TEST(Bake, NormalMapsOfAnotherSizeFollowTheColours) {
  PicturedQuad quad(pattern(8, 8, 3));
  Image normal(4, 4, 3);
  for (int i = 0; i < 16; ++i) {
    normal.values[3 * i] = 0.5f;
    normal.values[3 * i + 1] = 0.8f;
    normal.values[3 * i + 2] = 0.9f;
  }
  write_png(quad.folder / "n.png", normal);
  quad.scan.materials[0].normal = {quad.folder / "n.png", nullptr};
  const Model model = bake_model(quad.scan, regions_of({kSkin}), kTable, {});
  const float* const n = model.sets[0].normal.pixel(3, 5);
  EXPECT_EQ(model.sets[0].normal.width_px, 8);
  EXPECT_NEAR(length(Vec3f{n[0], n[1], n[2]}), 1, 1e-6f);
  EXPECT_NEAR(n[1], 0.6f, 0.01f);
}

TEST(Bake, OneSetAMaterialAndEachHasItsOwnMap) {
  std::vector<Quad> quads = two_charts();
  const Model model = bake_model(scan_of(quads, true), regions_of({kSkin, kFabric}), kTable, {});
  ASSERT_EQ(model.sets.size(), 2u);
  EXPECT_EQ(model.sets[1].name, "material1");
  EXPECT_EQ(*model.sets[1].roughness.pixel(700, 500), 0.85f);
  EXPECT_EQ(*model.sets[0].roughness.pixel(300, 500), 0.4f);
}

TEST(Bake, RepeatsAndOverlapsAreReported) {
  std::vector<Quad> quads = two_charts();
  for (Vec2f& uv : quads[0].uv) uv.x -= 0.2f;  // crosses u = 0
  quads.push_back(quads[1]);
  for (Vec3f& p : quads[2].position) p.z += 1;  // elsewhere, in the same texels
  BakeOptions options;
  options.size_px = 100;
  BakeReport report;
  const Model model =
      bake_model(scan_of(quads), regions_of({kHair, kFabric, kFabric}), kTable, options, &report);
  EXPECT_EQ(*model.sets[0].roughness.pixel(95, 50), 0.5f);
  EXPECT_EQ(*model.sets[0].roughness.pixel(5, 50), 0.5f);
  EXPECT_EQ(report.sets[0].overlapping_texels, 30u * 80u);
  EXPECT_EQ(report.sets[0].hidden_triangles, 2u);
  EXPECT_EQ(report.sets[0].uvs_outside, 3u + 0u);
  ASSERT_EQ(warnings_of(report).size(), 2u);
  expect_message(warnings_of(report)[0], {"50.0 % of its texels show more than one face", "2 triangles"});
  expect_message(warnings_of(report)[1], {"corners have UVs outside [0,1]"});
}

TEST(Bake, SameBytesForAnyNumberOfThreads) {
  const TemporaryFolder folder;
  PicturedQuad quad(pattern(300, 200, 3));
  quad.scan.materials[0].normal = quad.scan.materials[0].alpha = quad.scan.materials[0].diffuse;
  BakeOptions options;
  options.size_px = 150;
  options.name = "quad";
  for (size_t threads : {1, 2, 8}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    bake_to_folder(quad.scan, canonical_mesh(quad.scan, regions_of({kSkin}), 1), kTable, options,
                   folder / std::to_string(threads));
  }
  int files = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder / "1")) {
    if (!entry.is_regular_file()) continue;
    ++files;
    const std::string relative = std::filesystem::relative(entry.path(), folder / "1").string();
    for (const char* other : {"2", "8"})
      EXPECT_EQ(read_file(entry.path()), read_file(folder / other / relative)) << relative;
  }
  EXPECT_GT(files, 15);
}

TEST(Bake, RefusesInWords) {
  const Quad plane = tilted_plane(0, false);
  Scan no_uv = scan_of({plane}), far_uv = scan_of({plane}), wide_uv = scan_of({plane}),
       flat = scan_of({plane});
  no_uv.corners[2].uv = Corner::kNoUv;
  far_uv.uvs[1].x = 4096;
  wide_uv.uvs[1].x = 12;
  for (Vec3f& p : flat.positions) p = {1, 2, 3};
  const Scan scan = scan_of({plane});
  const Regions skin = regions_of({kSkin});
  expect_message(input_error_of([&] { canonical_mesh(no_uv, skin, 1); }), {"quads.obj: face 0", "has no UV"});
  expect_message(input_error_of([&] { canonical_mesh(far_uv, skin, 1); }),
                 {"UV coordinate beyond 1024", "pixels"});
  expect_message(input_error_of([&] { canonical_mesh(wide_uv, skin, 1); }),
                 {"spans more than 8 repetitions"});
  expect_message(input_error_of([&] { canonical_mesh(flat, skin, 1); }), {"no face has an area"});
  expect_message(input_error_of([&] {
                   canonical_mesh(scan, regions_of({kSkin, kSkin}), 1);
                 }),
                 {"has 1 faces, the regions have 2"});
  expect_message(input_error_of([&] { canonical_mesh(scan, regions_of({kUnlabelled}), 1); }),
                 {"face 0", "has no class", "label every face"});
}

}  // namespace
}  // namespace ohb
