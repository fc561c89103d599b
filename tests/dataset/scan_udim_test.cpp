// Scans whose pictures are tiled over UV space: from files to maps.
#include <gtest/gtest.h>

#include "dataset/commands/label.h"
#include "dataset/studies/bake_fidelity.h"
#include "tests/support/scan_files.h"
#include "tests/support/test_files.h"
#include "tests/support/tube_person.h"

namespace ohb {
using namespace bake;
using namespace commands;
using namespace labelling;
using namespace studies;
using namespace surface;
using namespace validation;
namespace {

namespace fs = std::filesystem;

void write_flat_png(const fs::path& file, float value) {
  Image image(8, 8, 3);
  for (float& v : image.values) v = value;
  write_png(file, image);
}

/// Three squares in tiles 1001, 1002 and 1011 that meet at u = 1 and v = 1 and share those UVs.
fs::path write_tiled(const fs::path& folder, const std::string& picture = "skin.<UDIM>.png") {
  write_bytes(folder / "tiled.mtl", "newmtl skin\nmap_Kd " + picture + "\n");
  write_flat_png(folder / "skin.1001.png", 0.25f);
  write_flat_png(folder / "skin.1002.png", 0.5f);
  write_flat_png(folder / "skin.1011.png", 0.75f);
  return write_bytes(
      folder / "tiled.obj",
      "mtllib tiled.mtl\nusemtl skin\nv 0 0 0\nv 80 0 0\nv 160 0 0\nv 0 80 0\nv 80 80 0\nv 160 80 0\n"
      "v 0 160 0\nv 80 160 0\nvt 0 0\nvt 1 0\nvt 2 0\nvt 0 1\nvt 1 1\nvt 2 1\nvt 0 2\nvt 1 2\n"
      "f 1/1 2/2 5/5 4/4\nf 2/2 3/3 6/6 5/5\nf 4/4 5/5 8/8 7/7\n");
}

TEST(Udim, EachTileIsAMaterialWithItsPicture) {
  const TemporaryFolder folder;
  for (const char* picture : {"skin.<UDIM>.png", "skin.1001.png"}) {
    const Scan scan = read_scan(write_tiled(folder.path(), picture));
    ASSERT_EQ(scan.materials.size(), 3u) << picture;
    const char* const names[] = {"skin.1001", "skin.1002", "skin.1011"};
    for (size_t f = 0; f < 3; ++f) {
      const ScanMaterial& material = scan.materials[scan.face_material[f]];
      EXPECT_EQ(material.name, names[f]);
      EXPECT_EQ(material.diffuse.file.filename().string(), std::string(names[f]) + ".png");
      for (uint32_t c = scan.face_begin[f]; c < scan.face_begin[f + 1]; ++c) {
        const Vec2f uv = scan.uvs[scan.corners[c].uv];
        EXPECT_TRUE((uv.x == 0 || uv.x == 1) && (uv.y == 0 || uv.y == 1)) << uv.x << " " << uv.y;
      }
    }
  }
}

TEST(Udim, TilesAreBakedIntoSetsOfTheirOwn) {
  const TemporaryFolder folder;
  LabelJob label;
  label.scan = write_tiled(folder.path());
  label.output = folder / "regions";
  label_scan(label);
  BakeJob job;
  job.scan = label.scan;
  job.regions = label.output;
  job.output = folder / "model";
  job.quiet = true;
  EXPECT_TRUE(warnings_of(bake_scan(job).bake).empty()) << "no UV is outside";
  const Model model = read_model(job.output);
  ASSERT_EQ(model.sets.size(), 3u);
  for (const ModelTriangle& triangle : model.triangles)
    EXPECT_NEAR(*model.sets[triangle.set].albedo.pixel(4, 4),
                srgb_to_linear(0.25f * static_cast<float>(1 + triangle.source_face)), 4e-3f);
}

TEST(Udim, WhatIsNoTileStaysARepetition) {
  const TemporaryFolder folder;
  const fs::path file = write_tiled(folder.path(), "skin.1001.png");
  fs::remove(folder / "skin.1002.png");
  expect_message(input_error_of([&] { read_scan(file); }), {"tiled.obj", "face 2", "1002", "skin.1002.png"});
  fs::remove(folder / "skin.1011.png");
  EXPECT_EQ(read_scan(file).materials.size(), 1u);
  write_flat_png(folder / "p21001.png", 0.5f);
  write_flat_png(folder / "p21002.png", 0.5f);
  write_bytes(folder / "tiled.mtl", "newmtl skin\nmap_Kd p21001.png\n");
  EXPECT_EQ(read_scan(file).materials.size(), 1u) << "no number of four digits";
  write_flat_png(folder / "img_1050.png", 0.5f);
  write_flat_png(folder / "img_1051.png", 0.5f);
  write_bytes(folder / "tiled.mtl", "newmtl skin\nmap_Kd img_1050.png\n");
  EXPECT_EQ(read_scan(file).materials.size(), 1u) << "no face is in tile 1050";
  write_bytes(folder / "tiled.mtl", "newmtl skin\nmap_Kd none.<UDIM>.png\n");
  expect_message(input_error_of([&] { read_scan(file); }),
                 {"none.<UDIM>.png", "is not there", "none.1001.png"});
}

/// A person whose upper half lies in tile 1002, whose picture is the same, renders as the one of one tile.
TEST(Udim, ATiledPersonRendersAsTheSameOnOneTile) {
  TubePerson person;
  make_tube_person(24, 60, person);
  const fs::path folder = person.folder.path();
  for (const char* name : {"t.1001.png", "t.1002.png"})
    fs::copy_file(person.scan.materials[0].diffuse.file, folder / name);
  write_bytes(folder / "t.mtl", "newmtl body\nmap_Kd t.<UDIM>.png\n");
  std::string obj = "mtllib t.mtl\nusemtl body\n";
  for (const Vec3f p : person.scan.positions)
    obj += "v " + std::to_string(p.x) + " " + std::to_string(p.y) + " " + std::to_string(p.z) + "\n";
  for (int tile = 0; tile < 2; ++tile)
    for (const Vec2f uv : person.scan.uvs)
      obj += "vt " + std::to_string(uv.x + static_cast<float>(tile)) + " " + std::to_string(uv.y) + "\n";
  for (size_t f = 0; f < person.scan.face_count(); ++f) {
    obj += "f";
    const bool is_upper =
        person.scan.positions[person.scan.corners[person.scan.face_begin[f]].position].y > 100;
    for (uint32_t c = person.scan.face_begin[f]; c < person.scan.face_begin[f + 1]; ++c)
      obj += " " + std::to_string(person.scan.corners[c].position + 1) + "/" +
             std::to_string(person.scan.corners[c].uv + 1 + (is_upper ? person.scan.uvs.size() : 0));
    obj += "\n";
  }
  const Scan tiled = read_scan(write_bytes(folder / "t.obj", obj));
  ASSERT_EQ(tiled.materials.size(), 2u);
  const MaterialTable table = {
      {{0.184f, 0.4f, 0.08f}, {0.239f, 0.5f, 0}, {0.263f, 0.85f, 0}, {0.224f, 0.25f, 0}}};
  const Regions regions{person.truth, std::string(64, '0')};
  Environment environment;
  environment.radiance = Image(8, 4, 3);
  for (float& value : environment.radiance.values) value = 1;
  FidelitySettings settings;
  settings.size_px = 48;
  settings.spp = 8;
  const FidelityPoint point =
      compare_models(bake_model(tiled, regions, table, {}), bake_model(person.scan, regions, table, {}),
                     environment, settings);
  EXPECT_TRUE(point.failures.empty()) << point.failures.front();
  EXPECT_LT(point.relative_error, 0.01);
}

}  // namespace
}  // namespace ohb
