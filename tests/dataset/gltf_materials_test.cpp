// What glTF's materials look like: pictures with transforms and wrapping, factors, opacity, colours at
// vertices.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>

#include "bake/bake.h"
#include "dataset/labelling/face_colours.h"
#include "dataset/model/atomic_file.h"
#include "dataset/surface/picture.h"
#include "tests/support/gltf_files.h"
#include "tests/support/paths.h"
#include "tests/support/test_files.h"

namespace ohb {
using namespace bake;
using namespace labelling;
using namespace surface;
namespace {

constexpr int kSize_px = 32;
constexpr const char* kSpecGloss = "KHR_materials_pbrSpecularGlossiness";

/// 8 x 4 pixels, each of its own colour, or clear in steps.
std::string picture_bytes(int channels = 3) {
  const TemporaryFolder folder;
  Image picture(8, 4, channels);
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 8; ++x) {
      float* const p = picture.pixel(x, y);
      p[0] = static_cast<float>(30 * x + 20) / 255;
      p[1] = static_cast<float>(60 * y + 30) / 255;
      p[2] = static_cast<float>((x + y) % 2 * 200) / 255;
      if (channels == 4) p[3] = static_cast<float>(32 * x) / 255;
    }
  write_png(folder / "p.png", picture);
  return read_file(folder / "p.png");
}

/// The files of the tests, each one way of showing the picture.
GlbBuilder pictured(int channels = 3, const nlohmann::json& sampler = {{"magFilter", 9728}}) {
  GlbBuilder glb;
  glb.colour_info() = glb.add_picture(picture_bytes(channels), sampler);
  return glb;
}

nlohmann::json sampler_of(int wrap_s, int wrap_t) {
  return {{"wrapS", wrap_s}, {"wrapT", wrap_t}, {"magFilter", 9728}};
}

GlbBuilder transformed(const nlohmann::json& transform) {
  GlbBuilder glb = pictured();
  glb.colour_info()["extensions"]["KHR_texture_transform"] = transform;
  glb.json["extensionsUsed"] = {"KHR_texture_transform"};
  return glb;
}

GlbBuilder wrapped(int wrap_s, int wrap_t) {
  GlbBuilder glb = pictured(3, sampler_of(wrap_s, wrap_t));
  glb.set_uvs({-1, 2, 2.5f, 2, 2.5f, -0.5f, -1, -0.5f});
  return glb;
}

GlbBuilder with_colours(GlbBuilder glb) {
  // Bytes that Blender's own 8-bit colours hold as they are: 0 and 1.
  glb.primitive()["attributes"]["COLOR_0"] = glb.add<uint8_t>(
      {255, 0, 0, 255, 0, 255, 0, 255, 255, 255, 255, 255, 0, 0, 255, 0}, "VEC4", 5121, true);
  return glb;
}

GlbBuilder spec_gloss() {
  GlbBuilder glb = pictured();
  glb.material()["extensions"][kSpecGloss] = {{"diffuseTexture", glb.colour_info()},
                                              {"diffuseFactor", {0.5, 0.25, 1, 1}}};
  glb.material().erase("pbrMetallicRoughness");
  glb.json["extensionsUsed"] = {kSpecGloss};
  return glb;
}

GlbBuilder blended(const char* mode, float factor, int channels) {
  GlbBuilder glb = pictured(channels);
  glb.material()["alphaMode"] = mode;
  glb.material()["pbrMetallicRoughness"]["baseColorFactor"] = {1, 1, 1, factor};
  return glb;
}

Scan read(const GlbBuilder& glb, const TemporaryFolder& folder) {
  return read_scan(write_bytes(folder / "a.glb", glb.bytes()));
}
Scan read(const GlbBuilder& glb) {
  const TemporaryFolder folder;
  return read(glb, folder);
}

/// What a point of the square shows: colour and opacity.
struct Look {
  Vec3f colour;
  float alpha;
};

/// The nearest pixel.
std::vector<float> pixel_at(const Image& image, Vec2f uv) {
  const auto index = [](float at, int size) {
    return std::min(size - 1, static_cast<int>((at - std::floor(at)) * static_cast<float>(size)));
  };
  const float* const p =
      image.pixel(index(uv.x, image.width_px), image.height_px - 1 - index(uv.y, image.height_px));
  return {p, p + image.channels};
}

/// By the scan alone: the reading of what its material and its colours mean, as simple as can be.
Look look_at(const Scan& scan, float x, float y) {
  for (size_t f = 0; f < scan.face_count(); ++f) {
    const Corner* const c = &scan.corners[scan.face_begin[f]];
    const auto p = [&](int i) { return scan.positions[c[i].position]; };
    const Vec3f a = p(1) - p(0), b = p(2) - p(0);
    const float d = a.x * b.y - a.y * b.x, px = x - p(0).x, py = y - p(0).y;
    const float s = (px * b.y - py * b.x) / d, t = (a.x * py - a.y * px) / d;
    if (s < 0 || t < 0 || s + t > 1) continue;
    const float w[3] = {1 - s - t, s, t};
    Vec2f uv;
    VertexColour at{{0, 0, 0}, 0};
    for (int i = 0; i < 3; ++i) {
      uv = uv + w[i] * scan.uvs[c[i].uv];
      const VertexColour own =
          scan.corner_colours.empty() ? VertexColour{} : scan.corner_colours[scan.face_begin[f] + size_t(i)];
      at.rgb += w[i] * own.rgb;
      at.alpha += w[i] * own.alpha;
    }
    const ScanMaterial& material = scan.materials[scan.face_material[f]];
    Look look{material.diffuse_factor * at.rgb, at.alpha};
    if (!material.diffuse.empty()) {
      const std::vector<float> rgb = pixel_at(read_colour_picture(material.diffuse), uv);
      look.colour = look.colour * Vec3f{rgb[0], rgb[1], rgb[2]};
    }
    if (!material.alpha.empty()) look.alpha *= pixel_at(read_alpha_picture(material), uv)[0];
    look.alpha = material.opacity_of(look.alpha);
    return look;
  }
  ADD_FAILURE() << "no face at " << x << " " << y;
  return {};
}

TEST(GltfMaterials, LookAsBlenderShowsThem) {
  if (std::system("blender --version > /dev/null 2>&1") != 0) GTEST_SKIP() << "Blender is not there";
  const std::vector<std::pair<std::string, GlbBuilder>> files{
      {"scaled", transformed({{"offset", {0.25, 0.5}}, {"scale", {2, 0.5}}})},
      {"turned", transformed({{"offset", {0.1, 0.3}}, {"rotation", 0.5}, {"scale", {1.5, 2.25}}})},
      {"mirrored", wrapped(33648, 33648)},
      {"clamped", wrapped(33071, 33071)},
      {"mixed", wrapped(33648, 33071)},
      {"coloured", with_colours(pictured())},
      {"only_coloured", with_colours(GlbBuilder())},
      {"spec_gloss", spec_gloss()},
      {"blended", blended("BLEND", 0.5f, 4)},
      {"clear", blended("BLEND", 0.05f, 3)}};
  const TemporaryFolder folder;
  std::string command = "blender -b --factory-startup -noaudio -P " +
                        source_path("tests/dataset/blender_look.py") + " -- " + folder.path().string();
  for (const auto& [name, glb] : files)
    command += " " + write_bytes(folder / (name + ".glb"), glb.bytes()).string();
  ASSERT_EQ(std::system((command + " > /dev/null 2>&1").c_str()), 0);
  for (const auto& [name, glb] : files) {
    const Scan scan = read_scan(folder / (name + ".glb"));
    const Image colour = read_image(folder / (name + "_colour.exr")),
                alpha = read_image(folder / (name + "_alpha.exr"));
    ASSERT_EQ(colour.width_px, kSize_px);
    int others = 0;  // pixels of the picture are told apart but for rounding at their edges
    for (int y = 0; y < kSize_px; ++y)
      for (int x = 0; x < kSize_px; ++x) {
        const Look look = look_at(scan, (x + 0.5f) / kSize_px, 1 - (y + 0.5f) / kSize_px);
        float worst = std::abs(look.alpha - *alpha.pixel(x, y));
        if (name == "spec_gloss") worst = 0;  // that importer has no such socket
        // Without its alpha, Blender's picture is premultiplied by it.
        for (int c = 0; c < 3 && name != "blended"; ++c)
          worst = std::max(worst, std::abs(look.colour[c] - colour.pixel(x, y)[c]));
        others += worst > 0.01f;
      }
    EXPECT_LT(others, kSize_px * kSize_px / 100) << name;
  }
}

/// The map that a bake makes of the only material.
TextureSet baked(const Scan& scan) {
  Regions regions;
  regions.face_class.assign(scan.face_count(), kSkin);
  MaterialTable table{};
  for (ClassMaterial& of : table) of = {0.5f, 0.5f, 0.0f};
  return bake_model(scan, regions, table, {}).sets.at(0);
}

TEST(GltfMaterials, MasksAreThresholdedAndNeverHalfClear) {
  const TemporaryFolder folder;
  for (const float cutoff : {0.3f, 0.5f}) {
    GlbBuilder glb = blended("MASK", 1, 4);
    glb.material()["alphaCutoff"] = cutoff;
    const Image alpha = baked(read(glb, folder)).alpha;
    ASSERT_EQ(alpha.width_px, 8);
    for (int x = 0; x < 8; ++x)
      EXPECT_EQ(*alpha.pixel(x, 2), 32.0f * static_cast<float>(x) / 255 >= cutoff ? 1.0f : 0.0f);
  }
  // The factor counts before the cutoff: .4 x .8 is below .5 everywhere but where alpha is above .625.
  const Image alpha = baked(read(blended("MASK", 0.8f, 4), folder)).alpha;
  EXPECT_EQ(*alpha.pixel(4, 1), 0.0f);
  EXPECT_EQ(*alpha.pixel(5, 1), 1.0f);
}

TEST(GltfMaterials, OpacityMultipliesTheCutOutOrIsAllThereIs) {
  const TemporaryFolder folder;
  EXPECT_FLOAT_EQ(*baked(read(blended("BLEND", 0.5f, 4), folder)).alpha.pixel(4, 1), 0.5f * 128 / 255);
  const Scan clear = read(blended("BLEND", 0.05f, 3), folder);
  for (float value : baked(clear).alpha.values) EXPECT_FLOAT_EQ(value, 0.05f);
  EXPECT_TRUE(baked(read(blended("OPAQUE", 0.05f, 4), folder)).alpha.values.empty());
  EXPECT_TRUE(baked(read(blended("MASK", 0.6f, 3), folder)).alpha.values.empty());
}

TEST(GltfMaterials, ColoursAtVerticesAreBakedAndLabelledAlike) {
  const TemporaryFolder folder;
  for (const bool has_picture : {false, true}) {
    const GlbBuilder glb = with_colours(has_picture ? pictured() : GlbBuilder());
    const Scan scan = read(glb, folder);
    EXPECT_TRUE(scan.materials[0].has_vertex_colours);
    EXPECT_FALSE(scan.materials[0].has_vertex_alpha) << "an opaque material has no use for alpha";
    const Image albedo = baked(scan).albedo;
    Vec3f mean;
    int count = 0;
    for (int i = 0; i < albedo.height_px; i += std::max(1, albedo.height_px / 64))
      for (int j = 0; j < albedo.width_px; j += std::max(1, albedo.width_px / 64)) {
        const float x = (j + 0.5f) / albedo.width_px, y = 1 - (i + 0.5f) / albedo.height_px;
        const Vec3f expected = look_at(scan, x, y).colour;
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(albedo.pixel(j, i)[c], expected[c], 2e-3f) << x << " " << y;
        mean += expected;
        ++count;
      }
    mean = mean * (1.0f / static_cast<float>(count));
    const std::vector<Vec3f> faces = mean_face_colours(scan);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(0.5f * (faces[0][c] + faces[1][c]), mean[c], 0.02f);
  }
}

TEST(GltfMaterials, FloatAndShortColoursWithAndWithoutAlpha) {
  GlbBuilder glb;
  glb.primitive()["attributes"]["COLOR_0"] =
      glb.add<float>({0.5f, 0, 0, 0, 1, 0, -1, 0, 2, 0, 0, 0}, "VEC3", 5126);
  const Scan scan = read(glb);
  EXPECT_EQ(scan.corner_colours[0].rgb.x, 0.5f);
  EXPECT_EQ(scan.corner_colours[2].rgb.x, 0.0f) << "below black is black";
  EXPECT_EQ(scan.corner_colours[2].rgb.z, 2.0f);
  GlbBuilder shorts;
  shorts.material()["alphaMode"] = "BLEND";
  std::vector<uint16_t> values(16, 65535);
  values[3] = 13107;
  shorts.primitive()["attributes"]["COLOR_0"] = shorts.add(values, "VEC4", 5123, true);
  const Scan clear = read(shorts);
  EXPECT_FLOAT_EQ(clear.corner_colours[0].alpha, 0.2f);
  EXPECT_TRUE(clear.materials[0].has_vertex_alpha);
  EXPECT_FALSE(clear.materials[0].is_opaque());
  GlbBuilder wrong;
  wrong.primitive()["attributes"]["COLOR_0"] = wrong.add<float>({1, 1, 1, 1, 1, 1, 1, 1}, "VEC2", 5126);
  expect_message(input_error_of([&] { read(wrong); }), {"colours of 2 channels"});
}

TEST(GltfMaterials, OtherExtensionsAreNamed) {
  GlbBuilder glb = pictured();
  glb.material()["extensions"]["KHR_materials_sheen"] = nlohmann::json::object();
  glb.material()["extensions"]["KHR_materials_ior"] = nlohmann::json::object();
  const Scan scan = read(glb);
  ASSERT_EQ(scan.notes.size(), 1u);
  EXPECT_NE(scan.notes[0].find("KHR_materials_ior, KHR_materials_sheen are not used"), std::string::npos);
}

TEST(GltfMaterials, PicturesOfOtherKindsAreReadOrReported) {
  GlbBuilder glb = pictured();
  glb.json["textures"][0].erase("source");
  glb.json["textures"][0]["extensions"]["KHR_texture_basisu"]["source"] = 0;
  const TemporaryFolder folder;
  const std::filesystem::path file = write_bytes(folder / "a.glb", glb.bytes());
  expect_message(input_error_of([&] { read_scan(file); }), {"KHR_texture_basisu", "PNG or JPEG"});
  const Scan reported = read_scan(file, MissingFiles::kReported);
  EXPECT_EQ(reported.missing.size(), 1u);
  glb.json["textures"][0]["extensions"] = {{"EXT_texture_webp", {{"source", 0}}}};
  EXPECT_FALSE(read(glb).materials[0].diffuse.empty());
}

TEST(GltfMaterials, NormalMapsWithOtherUvsAreLeftOutAndNoted) {
  GlbBuilder glb = pictured();
  glb.material()["normalTexture"] = glb.add_picture(picture_bytes());
  glb.material()["normalTexture"]["texCoord"] = 1;
  const Scan scan = read(glb);
  EXPECT_TRUE(scan.materials[0].normal.empty());
  ASSERT_EQ(scan.notes.size(), 1u);
  EXPECT_NE(scan.notes[0].find("other UVs"), std::string::npos);
}

}  // namespace
}  // namespace ohb
