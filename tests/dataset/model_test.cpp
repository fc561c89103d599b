#include "dataset/model/model.h"

#include <cmath>
#include <random>

#include "dataset/model/atomic_file.h"
#include "dataset/model/model_files.h"
#include "tests/support/test_files.h"

namespace ohb {
namespace {

Image constant_image(int width, int height, int channels, float value) {
  Image image(width, height, channels);
  for (float& v : image.values) v = value;
  return image;
}

TextureSet random_set(const std::string& name, int width, int height, bool with_optional) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> unit(0, 1);
  TextureSet set;
  set.name = name;
  for (const MapKind& kind : kMapKinds) {
    if (kind.is_optional && !with_optional) continue;
    Image image(width, height, kind.channels);
    // Halves are exact for multiples of 1/1024 below 1; floats may be anything.
    for (float& v : image.values)
      v = kind.is_float ? 100 * unit(random) - 50 : std::floor(1024 * unit(random)) / 1024;
    set.*kind.image = image;
  }
  set.valid = constant_image(width, height, 1, 1);
  set.valid.values[0] = 0;
  set.valid.values[1] = 0.5f;
  return set;
}

/// Two triangles in two sets, numbers that do not survive six digits.
Model small_model() {
  Model model;
  model.name = "small";
  model.source_sha256 = std::string(64, 'a');
  model.source_file = "small & \"odd\" <scan>.obj";
  model.source_unit_cm = 100;
  model.source_shift_cm = {0.1f, -1.0f / 3, 1e-20f};
  model.positions_cm = {
      {0.1f, 1.0f / 3, 1e-30f}, {123.456789f, -0.0f, 3}, {1, 2, std::nextafter(3.0f, 4.0f)}, {5, 6, 7}};
  model.uvs = {{0, 0}, {1.0f / 3, 0.7f}, {-3.25f, 1e-7f}};
  model.triangles = {{{0, 1, 2}, {0, 1, 2}, 1, 2, 70000}, {{1, 3, 2}, {2, 1, 0}, 0, 3, 0}};
  model.sets = {random_set("skin", 7, 5, true), random_set("SKIN", 4, 4, false)};
  return model;
}

TEST(Model, ReadsBackExactlyWhatWasWritten) {
  const TemporaryFolder folder;
  const Model model = small_model();
  write_model(folder / "m", model);
  const Model back = read_model(folder / "m");
  EXPECT_EQ(back.name, model.name);
  EXPECT_EQ(back.source_sha256, model.source_sha256);
  EXPECT_EQ(back.source_file, model.source_file);
  EXPECT_EQ(back.source_unit_cm, 100);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(back.source_shift_cm[i], model.source_shift_cm[i]);
  ASSERT_EQ(back.positions_cm.size(), model.positions_cm.size());
  for (size_t i = 0; i < model.positions_cm.size(); ++i)
    for (int c = 0; c < 3; ++c) EXPECT_EQ(back.positions_cm[i][c], model.positions_cm[i][c]);
  ASSERT_EQ(back.uvs.size(), model.uvs.size());
  for (size_t i = 0; i < model.uvs.size(); ++i) {
    EXPECT_EQ(back.uvs[i].x, model.uvs[i].x);
    EXPECT_EQ(back.uvs[i].y, model.uvs[i].y);
  }
  ASSERT_EQ(back.triangles.size(), model.triangles.size());
  for (size_t i = 0; i < model.triangles.size(); ++i) {
    const ModelTriangle &a = back.triangles[i], &b = model.triangles[i];
    for (int c = 0; c < 3; ++c) EXPECT_TRUE(a.position[c] == b.position[c] && a.uv[c] == b.uv[c]);
    EXPECT_EQ(a.set, b.set);
    EXPECT_EQ(a.material_class, b.material_class);
    EXPECT_EQ(a.source_face, b.source_face);
  }
  ASSERT_EQ(back.sets.size(), 2u);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(back.sets[i].name, model.sets[i].name);
    EXPECT_EQ(back.sets[i].valid.values, model.sets[i].valid.values);
    for (const MapKind& kind : kMapKinds)
      EXPECT_EQ((back.sets[i].*kind.image).values, (model.sets[i].*kind.image).values) << kind.name;
  }
}

TEST(Model, PicturesNeedNoDisplacementAndNoValidity) {
  const TemporaryFolder folder;
  const Model model = small_model();
  write_model(folder / "m", model);
  for (const char* set : {"skin", "SKIN_2"})
    for (const char* file : {"displacement.exr", "valid.png"})
      ASSERT_TRUE(std::filesystem::remove(folder / "m" / "maps" / set / file)) << set << "/" << file;
  const Model back = read_model(folder / "m", ModelParts::kForRendering);
  ASSERT_EQ(back.triangles.size(), model.triangles.size());
  for (size_t i = 0; i < model.sets.size(); ++i) {
    EXPECT_TRUE(back.sets[i].valid.values.empty() && back.sets[i].displacement.values.empty());
    for (const MapKind& kind : kMapKinds) {
      if (kind.image == &TextureSet::displacement) continue;
      EXPECT_EQ((back.sets[i].*kind.image).values, (model.sets[i].*kind.image).values) << kind.name;
    }
  }
  expect_message(input_error_of([&] { read_model(folder / "m"); }), {"displacement.exr", "no such file"});
}

TEST(Model, EqualModelsGiveEqualBytes) {
  const TemporaryFolder folder;
  write_model(folder / "a", small_model());
  write_model(folder / "b", small_model());
  int files = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder / "a")) {
    if (!entry.is_regular_file()) continue;
    ++files;
    const auto other = (folder / "b") / std::filesystem::relative(entry.path(), folder / "a").string();
    EXPECT_EQ(read_file(entry.path()), read_file(other)) << entry.path();
  }
  // All maps, valid.png and previews; the second set has no cut-out, and a flat normal map.
  EXPECT_EQ(files, 4 + (7 + 1 + 7) + (6 + 1 + 6));
}

TEST(Model, TextureSetFoldersArePortableAndUnique) {
  const std::vector<std::string> folders =
      texture_set_folders({"skin", "Skin", "../x", "", "a b/c", ".hidden", "H\xc3\xa4nd", "..", "skin"});
  EXPECT_EQ(folders, (std::vector<std::string>{"skin", "Skin_2", "_._x", "set", "a_b_c", "_hidden", "H__nd",
                                               "_.", "skin_3"}));
}

struct Damage {
  const char* name;
  std::function<void(const std::filesystem::path&)> apply;
  std::vector<std::string> message;
};

void replace_in(const std::filesystem::path& file, const std::string& from, const std::string& to) {
  std::string content = read_file(file);
  const size_t at = content.find(from);
  ASSERT_NE(at, std::string::npos) << from;
  write_file_atomically(file, content.replace(at, from.size(), to));
}

void damage_texel(const std::filesystem::path& file, float value) {
  std::vector<ExrPart> parts = read_exr(file);
  parts[0].image.values[9 * parts[0].image.channels] = value;
  write_exr(file, parts, {});
}

TEST(Model, RefusesDamagedFoldersInWords) {
  using Path = std::filesystem::path;
  const float nan = std::nanf("");
  const std::vector<Damage> damages = {
      {"no xml",
       [](const Path& m) { std::filesystem::remove(m / "model.xml"); },
       {"model.xml", "no such file"}},
      {"empty xml",
       [](const Path& m) { write_file_atomically(m / "model.xml", ""); },
       {"model.xml", "the file is empty"}},
      {"broken xml",
       [](const Path& m) { replace_in(m / "model.xml", "</model>", ""); },
       {"model.xml", "not well-formed XML"}},
      {"other root",
       [](const Path& m) { write_file_atomically(m / "model.xml", "<scene/>"); },
       {"root element is <scene>, expected <model>"}},
      {"newer schema",
       [](const Path& m) { replace_in(m / "model.xml", "schema=\"1.0\"", "schema=\"2.0\""); },
       {"line 2", "schema 2.0 is not known"}},
      {"attribute twice",
       [](const Path& m) { replace_in(m / "model.xml", "schema=\"1.0\"", "schema=\"1.0\" schema=\"1.0\""); },
       {"line 2", "'schema' occurs twice"}},
      {"count no number",
       [](const Path& m) { replace_in(m / "model.xml", "triangles=\"2\"", "triangles=\"two\""); },
       {"triangles=\"two\" is no whole number"}},
      {"count wrong",
       [](const Path& m) { replace_in(m / "model.xml", "triangles=\"2\"", "triangles=\"3\""); },
       {"mesh.obj", "holds 2 triangles, model.xml states 3"}},
      {"set leaves the folder",
       [](const Path& m) { replace_in(m / "model.xml", "folder=\"skin\"", "folder=\"../skin\""); },
       {"../skin", "no plain folder name"}},
      {"map not stated",
       [](const Path& m) { replace_in(m / "model.xml", "<map name=\"sss\" />", ""); },
       {"texture set 'skin'", "has no map 'sss'"}},
      {"no mesh",
       [](const Path& m) { std::filesystem::remove(m / "mesh.obj"); },
       {"mesh.obj", "no such file"}},
      {"position NaN",
       [](const Path& m) { replace_in(m / "mesh.obj", "v 5 6 7", "v 5 nan 7"); },
       {"mesh.obj", "position 3 is not finite"}},
      {"number broken",
       [](const Path& m) { replace_in(m / "mesh.obj", "v 5 6 7", "v 5 x 7"); },
       {"mesh.obj: line 6", "\"v 5 x 7\""}},
      {"index 0",
       [](const Path& m) { replace_in(m / "mesh.obj", "f 1/1", "f 0/1"); },
       {"mesh.obj: line 11", "f 0/1"}},
      {"index too large",
       [](const Path& m) { replace_in(m / "mesh.obj", "f 1/1", "f 9/1"); },
       {"triangle 0 has position index 8 of 4"}},
      {"UV too large",
       [](const Path& m) { replace_in(m / "mesh.obj", "f 1/1", "f 1/4"); },
       {"triangle 0 has UV index 3 of 3"}},
      {"unknown usemtl",
       [](const Path& m) { replace_in(m / "mesh.obj", "usemtl SKIN_2", "usemtl other"); },
       {"mesh.obj: line 10", "usemtl other"}},
      {"faces truncated",
       [](const Path& m) { write_file_atomically(m / "faces.bin", "OHBFACE1"); },
       {"faces.bin", "classes of 2 triangles"}},
      {"class 7",
       [](const Path& m) {
         std::string b = read_file(m / "faces.bin");
         b.back() = 7;
         write_file_atomically(m / "faces.bin", b);
       },
       {"triangle 1 has class 7 of 4"}},
      {"map missing",
       [](const Path& m) { std::filesystem::remove(m / "maps/skin/sss.exr"); },
       {"maps/skin/sss.exr", "no such file"}},
      {"map empty",
       [](const Path& m) { write_file_atomically(m / "maps/skin/sss.exr", ""); },
       {"maps/skin/sss.exr", "is empty (0 bytes)"}},
      {"map of another size",
       [](const Path& m) {
         std::filesystem::copy_file(m / "maps/SKIN_2/sss.exr", m / "maps/skin/sss.exr",
                                    std::filesystem::copy_options::overwrite_existing);
       },
       {"maps/skin/sss.exr", "is 4 x 4 x 1, model.xml states 7 x 5 x 1"}},
      {"texel NaN",
       [=](const Path& m) { damage_texel(m / "maps/skin/albedo.exr", nan); },
       {"albedo.exr: texel (2, 1)", "is not a finite number"}},
      {"texel infinite",
       [=](const Path& m) { damage_texel(m / "maps/skin/displacement.exr", INFINITY); },
       {"displacement.exr: texel (2, 1)"}},
      {"mask missing",
       [](const Path& m) { std::filesystem::remove(m / "maps/skin/valid.png"); },
       {"valid.png", "no such file"}},
  };
  const TemporaryFolder folder;
  write_model(folder / "whole", small_model());
  for (const Damage& damage : damages) {
    SCOPED_TRACE(damage.name);
    const std::filesystem::path copy = folder / damage.name;
    std::filesystem::copy(folder / "whole", copy, std::filesystem::copy_options::recursive);
    damage.apply(copy);
    const std::string message = input_error_of([&] { read_model(copy); });
    EXPECT_EQ(message.find('\n'), std::string::npos);
    for (const std::string& part : damage.message)
      EXPECT_NE(message.find(part), std::string::npos) << "\"" << part << "\" is not in: " << message;
  }
  expect_message(input_error_of([&] { read_model(folder / "absent"); }), {"absent", "no such folder"});
}

TEST(SmoothNormals, CubeCornersPointOutwardsWhateverTheDiagonals) {
  Model cube;
  for (int i = 0; i < 8; ++i)
    cube.positions_cm.push_back({float(i & 1) - 0.5f, float(i >> 1 & 1) - 0.5f, float(i >> 2 & 1) - 0.5f});
  const uint32_t quads[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& q : quads) {
    cube.triangles.push_back({{q[0], q[1], q[2]}, {0, 0, 0}, 0, 0, 0});
    cube.triangles.push_back({{q[0], q[2], q[3]}, {0, 0, 0}, 0, 0, 0});
  }
  const std::vector<Vec3f> normals = smooth_normals(cube);
  for (int i = 0; i < 8; ++i)
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(normals[i][c], 2 * cube.positions_cm[i][c] / std::sqrt(3.0f), 1e-6f);
}

TEST(SmoothNormals, DegenerateAndUnusedPositionsGetPlusZ) {
  Model model;
  model.positions_cm = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {9, 9, 9}};
  model.triangles = {{{0, 1, 2}, {0, 0, 0}, 0, 0, 0}, {{0, 0, 1}, {0, 0, 0}, 0, 0, 0}};
  for (const Vec3f& normal : smooth_normals(model)) EXPECT_EQ(normal.z, 1.0f);
}

TEST(Bounds, OfPositions) {
  const Bounds bounds = bounds_of({{1, 2, 3}, {-1, 5, 0}});
  EXPECT_EQ(bounds.low.x, -1.0f);
  EXPECT_EQ(bounds.high.y, 5.0f);
  EXPECT_EQ(bounds.low.z, 0.0f);
  EXPECT_EQ(bounds_of({}).high.x, 0.0f);
}

}  // namespace
}  // namespace ohb
