// Readers of MakeHuman's files: what they read, and what they say about files that are wrong.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "dataset/people/asset_file.h"
#include "dataset/people/body.h"
#include "dataset/people/garment_file.h"
#include "dataset/people/skeleton.h"
#include "tests/support/shared_data.h"
#include "tests/support/test_files.h"

namespace ohb::people {
namespace {
namespace fs = std::filesystem;

fs::path write(const fs::path& file, const std::string& text) {
  fs::create_directories(file.parent_path());
  std::ofstream(file) << text;
  return file;
}

TEST(MorphTargetFile, IsReadAndItsFaultsAreNamed) {
  const TemporaryFolder folder;
  const fs::path file = write(folder / "a.target", "# head\n0 .1 -.2 3e-1\n7 0 0 1\n");
  const MorphTarget target = read_morph_target(file, 8);
  ASSERT_EQ(target.vertices, (std::vector<uint32_t>{0, 7}));
  EXPECT_FLOAT_EQ(target.moves_dm[0].y, -.2f);
  const auto fault = [&](const std::string& text) {
    write(file, text);
    return input_error_of([&] { read_morph_target(file, 8); });
  };
  expect_message(fault("8 0 0 0\n"), {"a.target", "line 1", "vertex is 8", "there are 8"});
  expect_message(fault("0 0 0 0\n-1 0 0 0\n"), {"line 2", "vertex is -1"});
  expect_message(fault("1 0 nan 0\n"), {"line 1", "'nan'", "not a number"});
  expect_message(fault("1 0 0\n"), {"move is missing"});
  expect_message(fault("x 0 0 0\n"), {"'x'", "not an index"});
}

TEST(MorphTargetFile, GzipThatIsCutOffIsAnError) {
  const TemporaryFolder folder;
  const fs::path file = write(folder / "a.target.gz", "\x1f\x8b not gzip");
  expect_message(input_error_of([&] { read_morph_target(file, 8); }),
                 {"a.target.gz", "not a whole gzip file"});
}

/// A quad of four vertices, worn by a base of ten.
struct TinyGarment {
  TemporaryFolder folder;
  fs::path file;
  TinyGarment(const std::string& mhclo, const std::string& material = "diffuseColor 1 .5 0\n") {
    write(folder / "c/q.obj",
          "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
          "f 1/1 2/2 3/3 4/4\n");
    write(folder / "c/q.mhmat", material);
    file = write(folder / "c/q.mhclo", mhclo);
  }
  Garment read() const { return read_garment(folder.path(), file, 10); }
  std::string fault() const {
    return input_error_of([&] { read(); });
  }
};
const std::string kHead = "name q\nobj_file q.obj\nmaterial q.mhmat\nz_depth 12\nx_scale 0 1 2.0\n";
const std::string kAnchors = "verts 0\n3\n0 1 2 .5 .5 0 1 0 0\n0 1 2 1 0 0 0 1 0\n9\n";

TEST(GarmentFile, SitsOnTheBase) {
  const TinyGarment tiny(kHead + kAnchors + "\ndelete_verts\n2 4 - 6\n8\n");
  const Garment garment = tiny.read();
  EXPECT_FLOAT_EQ(garment.z_depth, 12);
  EXPECT_EQ(std::string(garment.hides.begin(), garment.hides.end()),
            std::string({0, 0, 1, 0, 1, 1, 1, 0, 1, 0}));
  EXPECT_FLOAT_EQ(garment.material.diffuse_colour.y, .5f);
  std::vector<Vec3f> base(10);
  base[1] = {4, 0, 0}, base[3] = {1, 2, 3};
  const std::vector<Vec3f> fit = fitted(garment, base);
  EXPECT_FLOAT_EQ(fit[0].z, 3);
  EXPECT_FLOAT_EQ(fit[1].x, 2 + 1 * 2) << "offset 1, scaled by |4 - 0| / 2";
  EXPECT_FLOAT_EQ(fit[2].y, 1) << "no y_scale: the offset as it is";
}

TEST(GarmentFile, FaultsAreNamed) {
  expect_message(TinyGarment(kHead + "verts 0\n3\n10\n").fault(),
                 {"q.mhclo", "line 8", "'10'", "there are 10"});
  expect_message(TinyGarment(kHead + "verts 0\n3\n").fault(), {"1 vertices are placed, and the mesh has 4"});
  expect_message(TinyGarment(kHead + kAnchors + "delete_verts\n5 - 2\n").fault(), {"runs backwards"});
  expect_message(TinyGarment("obj_file ../../q.obj\n").fault(), {"outside the assets' folder"});
  expect_message(TinyGarment("obj_file r.obj\n").fault(), {"'r.obj'", "not there"});
  expect_message(TinyGarment("x_scale 0 1 0\n").fault(), {"line 1", "not above 0"});
  expect_message(TinyGarment(kAnchors).fault(), {"names no obj_file"});
  expect_message(TinyGarment(kHead + kAnchors, "diffuseColor red\n").fault(), {"q.mhmat", "line 1", "'red'"});
}

const std::string kBvh =
    "HIERARCHY\nROOT root\n{\nOFFSET 0 0 0\nCHANNELS 6 Xposition Yposition Zposition Xrotation Yrotation "
    "Zrotation\n"
    "JOINT upperleg02.L\n{\nOFFSET 0 0 0\nCHANNELS 3 Xrotation Yrotation Zrotation\nJOINT lowerleg01.L\n{\n"
    "OFFSET 0 0 -4\nCHANNELS 3 Xrotation Yrotation Zrotation\nEnd Site\n{\nOFFSET 0 0 -4\n}\n}\n}\n}\n";

TEST(PoseFile, TurnsFromZUpToYUp) {
  const TemporaryFolder folder;
  const fs::path file =
      write(folder / "p.bvh", kBvh + "MOTION\nFrames: 1\nFrame Time: 0.04\n1 2 3 0 0 90 0 30 0 0 0 0\n");
  const Pose pose = read_pose(file);
  // 90 degrees about the file's up turns +Z (towards the viewer) to +X.
  const Vec3f turned = transformed(pose.rotations.at("root"), 0, 0, 1);
  EXPECT_NEAR(turned.x, 1, 1e-6);
}

TEST(PoseFile, FaultsAreNamed) {
  const TemporaryFolder folder;
  const auto fault = [&](const std::string& text) {
    const fs::path file = write(folder / "p.bvh", text);
    return input_error_of([&] { read_pose(file); });
  };
  expect_message(fault(kBvh), {"p.bvh", "no MOTION"});
  expect_message(fault(kBvh + "MOTION\nFrames: 1\nFrame Time: 1\n1 2 3\n"), {"value of root is missing"});
  expect_message(fault("HIERARCHY\n}\n"), {"line 2", "none opened"});
  expect_message(fault("HIERARCHY\nROOT a\n{\nCHANNELS 1 Wrotation\n"), {"line 4", "'Wrotation'"});
}

TEST(MacroTargets, SharesSumToOneForEachKind) {
  BodySliders sliders;
  sliders.male = .3f, sliders.years = 40, sliders.muscle = .7f, sliders.weight = .4f;
  sliders.african = .2f, sliders.asian = .3f, sliders.caucasian = .5f;
  float races = 0, universal = 0;
  for (const auto& [name, weight] : macro_targets(sliders)) {
    if (name.find("macrodetails/universal") == 0) universal += weight;
    if (name.find("macrodetails/african") == 0 || name.find("macrodetails/asian") == 0 ||
        name.find("macrodetails/caucasian") == 0)
      races += weight;
  }
  EXPECT_NEAR(races, 1, 1e-5);
  EXPECT_NEAR(universal, 1, 1e-5);
}

TEST(SharedAssets, GarmentsComeBackToTheirOwnPlaces) {
  OHB_SHARED_DATA_OR_SKIP(assets, "makehuman");
  const BaseMesh base = read_base_mesh(assets / "3dobjs/base.obj");
  const MorphTargets targets(assets / "targets", base.mesh.positions.size());
  const std::vector<Vec3f> woman = morphed(base, targets, {{"macrodetails/caucasian-female-young", 1.0f}});
  const std::vector<Vec3f> man = morphed(base, targets, {{"macrodetails/caucasian-male-young", 1.0f}});
  int exact = 0, all = 0;
  for (const auto& entry : fs::recursive_directory_iterator(assets / "clothes")) {
    if (entry.path().extension() != ".mhclo") continue;
    const Garment garment = read_garment(assets, entry.path(), woman.size());
    float best = 1e9f;
    for (const auto* body : {&base.mesh.positions, &woman, &man}) {
      const std::vector<Vec3f> fit = fitted(garment, *body);
      std::vector<float> errors;
      for (size_t i = 0; i < fit.size(); ++i) errors.push_back(length(fit[i] - garment.mesh.positions[i]));
      std::sort(errors.begin(), errors.end());
      best = std::min(best, errors[errors.size() * 9 / 10]);
    }
    ++all, exact += best < .01f;
  }
  EXPECT_EQ(all, 73);
  EXPECT_GT(exact, 50);
}

TEST(SharedAssets, HeightsFollowTheSlider) {
  OHB_SHARED_DATA_OR_SKIP(assets, "makehuman");
  const BaseMesh base = read_base_mesh(assets / "3dobjs/base.obj");
  const MorphTargets targets(assets / "targets", base.mesh.positions.size());
  const struct {
    float male, slider, dm;
  } table[] = {{1, .5f, 17.5f}, {0, .5f, 16.1f}, {1, .6f, 18.9f},
               {0, .6f, 17.5f}, {1, .4f, 16.7f}, {0, .4f, 15.3f}};
  for (const auto& row : table) {
    BodySliders sliders;
    sliders.male = row.male, sliders.height = row.slider, sliders.years = 30;
    EXPECT_NEAR(height_of(base, morphed(base, targets, macro_targets(sliders))), row.dm, .06f)
        << row.male << " " << row.slider;
  }
}

TEST(SharedAssets, EveryAssetReads) {
  OHB_SHARED_DATA_OR_SKIP(assets, "makehuman");
  const BaseMesh base = read_base_mesh(assets / "3dobjs/base.obj");
  const size_t count = base.mesh.positions.size();
  const Skeleton skeleton =
      read_skeleton(assets / "rigs/default.mhskel", assets / "rigs/default_weights.mhw", count);
  EXPECT_EQ(skeleton.bones.size(), 163u);
  int garments = 0, poses = 0;
  for (const auto& entry : fs::recursive_directory_iterator(assets)) {
    const fs::path& file = entry.path();
    if (file.extension() == ".mhclo") ++garments, read_garment(assets, file, count);
    if (file.extension() == ".bvh" && file.parent_path().filename() != "mpfb2" &&
        file.parent_path().filename() != "poseunits")
      ++poses, read_pose(file);
  }
  EXPECT_EQ(garments, 111);
  EXPECT_GE(poses, 60);
}

}  // namespace
}  // namespace ohb::people
