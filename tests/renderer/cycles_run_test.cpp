// Starting Blender: what is refused, and that nothing stays behind.
#include "renderer/validation/cycles_run.h"

#include <gtest/gtest.h>

#include <set>

#include "dataset/model/atomic_file.h"
#include "renderer/validation/cycles_scene.h"
#include "tests/support/test_files.h"

namespace ohb {
using namespace renderer;
using namespace validation;
namespace {

namespace fs = std::filesystem;

fs::path script(const TemporaryFolder& folder, const std::string& name, const std::string& body) {
  write_file_atomically(folder / name, "#!/bin/sh\n" + body + "\n");
  fs::permissions(folder / name, fs::perms::owner_all);
  return folder / name;
}

TEST(Blender, MissingOrWrongOnesAreNamed) {
  const TemporaryFolder folder;
  expect_message(input_error_of([&] { find_blender(folder / "nowhere"); }),
                 {"nowhere", "Blender was not found", "--blender"});
  expect_message(input_error_of([&] { find_blender(script(folder, "new", "echo Blender 4.2.1 LTS")); }),
                 {"new", "Blender 4.2.1", "3.4"});
  expect_message(input_error_of([&] { find_blender(script(folder, "other", "echo hello")); }),
                 {"does not answer"});
  EXPECT_EQ(find_blender(script(folder, "right", "echo Blender 3.4.1")).version, "3.4.1");
}

TEST(Blender, SecondModelWantsItsOwnVersion) {
  const TemporaryFolder folder;
  expect_message(
      input_error_of([&] { find_blender(script(folder, "old", "echo Blender 3.4.1"), ShadingModel::kV2); }),
      {"old", "Blender 3.4.1", "4.5", "--bpy"});
  EXPECT_EQ(find_blender(script(folder, "new", "echo Blender 4.5.3 LTS"), ShadingModel::kV2).version,
            "4.5.3");
  expect_message(input_error_of([&] { find_bpy(folder / "nothing", ShadingModel::kV2); }),
                 {"nothing/bin/python", "was not found", "--install-bpy"});
  // A folder that is there is never installed into.
  expect_message(input_error_of([&] { install_bpy(folder.path()); }),
                 {folder.path().string(), "does not have Blender 4.5", "not there yet"});
  EXPECT_TRUE(fs::is_directory(folder.path()));
  // A module: its Python is asked.
  fs::create_directories(folder / "module/bin");
  script(folder, "module/bin/python", "echo Blender 4.5.15 LTS");
  const Blender module = find_bpy(folder / "module", ShadingModel::kV2);
  EXPECT_TRUE(module.is_module);
  EXPECT_EQ(module.version, "4.5.15");
  expect_message(input_error_of([&] { find_bpy(folder / "module", ShadingModel::kV1); }), {"4.5.15", "3.4"});
}

TEST(Blender, FailureGivesItsReason) {
  const TemporaryFolder folder;
  write_file_atomically(folder / "scene.json", "{\"format\": \"another\"}");
  expect_message(input_error_of([&] { run_cycles(find_blender({}), folder.path(), 1); }),
                 {"stopped with code 1", "format 'another'"});
  EXPECT_FALSE(fs::exists(folder / "blender"));
}

TEST(CyclesSeeds, AreDistinct31BitNumbers) {
  const auto seeds = cycles_seeds(1, 100);
  ASSERT_EQ(seeds.size(), 100u);
  EXPECT_EQ(std::set<uint32_t>(seeds.begin(), seeds.end()).size(), 100u);
  for (const uint32_t seed : seeds) EXPECT_LT(seed, 1u << 31);
  EXPECT_NE(seeds, cycles_seeds(2, 100));
  EXPECT_EQ(cycles_seeds(1, 3), std::vector<uint32_t>(seeds.begin(), seeds.begin() + 3));
}

}  // namespace
}  // namespace ohb
