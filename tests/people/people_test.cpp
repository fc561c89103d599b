// The people command on assets that the test writes: equal seeds, resumption, refusals, and what bake needs.
#include "dataset/people/people.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "dataset/model/atomic_file.h"
#include "dataset/model/regions.h"
#include "dataset/surface/texel_coverage.h"
#include "tests/people/tiny_assets.h"
#include "tests/support/paths.h"
#include "tests/support/shared_data.h"
#include "tests/support/test_files.h"

namespace ohb::people {
using namespace surface;
namespace {
namespace fs = std::filesystem;

PeopleJob job_of(const fs::path& assets, const fs::path& output, int count) {
  PeopleJob job;
  job.assets = assets, job.output = output, job.count = count;
  job.draw.balanced = true;
  job.scan.atlas_px = 256, job.preview_px = 32;
  job.quiet = true;
  return job;
}

/// Bytes of every file of the people (not of index and contact sheet), by name.
std::map<std::string, std::string> files_of(const fs::path& folder, const std::string& starting_with = "p") {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = fs::relative(entry.path(), folder).string();
    if (entry.is_regular_file() && name.rfind(starting_with, 0) == 0) files[name] = read_file(entry.path());
  }
  return files;
}

TEST(People, EqualSeedsGiveEqualBytesWhateverTheCountAndTheThreads) {
  const TemporaryFolder folder;
  const TinyAssets assets(folder / "assets");
  make_people(job_of(folder / "assets", folder / "a", 4));
  {
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    make_people(job_of(folder / "assets", folder / "b", 4));
    make_people(job_of(folder / "assets", folder / "c", 2));
  }
  EXPECT_EQ(files_of(folder / "a"), files_of(folder / "b"));
  auto first_two = files_of(folder / "a", "p0000");
  first_two.merge(files_of(folder / "a", "p0001"));
  auto other = files_of(folder / "c");
  other.erase("people.json");
  EXPECT_EQ(first_two, other);
  PeopleJob seeded = job_of(folder / "assets", folder / "d", 2);
  seeded.draw.seed = 2;
  make_people(seeded);
  EXPECT_NE(files_of(folder / "c"), files_of(folder / "d"));
}

TEST(People, FinishedOnesStayAndBrokenOnesAreMadeAgain) {
  const TemporaryFolder folder;
  const TinyAssets assets(folder / "assets");
  const PeopleJob job = job_of(folder / "assets", folder / "out", 3);
  const PeopleReport first = make_people(job);
  const auto files = files_of(folder / "out");
  fs::remove(folder / "out" / first.people[1].name / (first.people[1].name + "_scan.jpg"));
  const PeopleReport second = make_people(job);
  EXPECT_TRUE(second.people[0].was_there);
  EXPECT_FALSE(second.people[1].was_there);
  EXPECT_TRUE(second.people[2].was_there);
  EXPECT_EQ(files, files_of(folder / "out"));
  PeopleJob other = job;
  other.draw.seed = 5;
  for (const MadePerson& made : make_people(other).people) EXPECT_FALSE(made.was_there);
}

TEST(People, ScansAreWhatLabelAndBakeTake) {
  const TemporaryFolder folder;
  const TinyAssets assets(folder / "assets");
  const PeopleReport report = make_people(job_of(folder / "assets", folder / "out", 1));
  const std::string name = report.people[0].name + "_scan";
  const fs::path base = folder / "out" / report.people[0].name;
  const Scan scan = read_scan(base / (name + ".obj"));
  const auto classes = read_face_classes(base / (name + ".labels.txt"), scan.face_count(), {});
  const std::set<uint8_t> kinds(classes.begin(), classes.end());
  EXPECT_TRUE(kinds.count(kSkin) && kinds.count(kHair) && kinds.count(kLeather));
  float low = 1e9f, high = -1e9f;
  for (const Vec3f& p : scan.positions) low = std::min(low, p.y), high = std::max(high, p.y);
  EXPECT_NEAR(low, 0, .01f);
  const nlohmann::json json = nlohmann::json::parse(read_file(base / (name + ".json")));
  EXPECT_NEAR(high, json.at("recipe").at("height_cm").get<float>(), 1) << "the tube has no hair above it";
  EXPECT_GT(json.at("credits").size(), 4u);
  std::vector<UvTriangle> triangles;
  for (const ScanTriangle& t : triangulate(scan)) {
    UvTriangle triangle;
    for (int k = 0; k < 3; ++k) triangle.uv[k] = scan.uvs[scan.corners[t.corner[k]].uv];
    triangles.push_back(triangle);
  }
  EXPECT_EQ(cover_texels(triangles, 256, 256).overlapping_texels, 0u);
}

TEST(People, SocksOfLeatherShoesAreFabric) {
  const TemporaryFolder folder;
  const TinyAssets assets(folder / "assets");
  const PeopleReport report = make_people(job_of(folder / "assets", folder / "out", 6));
  size_t shoes = 0, socks = 0;
  for (const MadePerson& made : report.people) {
    const fs::path base = folder / "out" / made.name / (made.name + "_scan");
    const Scan scan = read_scan(base.string() + ".obj");
    const auto classes = read_face_classes(base.string() + ".labels.txt", scan.face_count(), {});
    const nlohmann::json json = nlohmann::json::parse(read_file(base.string() + ".json"));
    bool has_leather_clothes = false;
    for (const auto& worn : json.at("recipe").at("clothes"))
      if (worn.at("file").get<std::string>().find("shoes") == std::string::npos)
        has_leather_clothes |=
            worn.at("lower").at("look") == "leather" || worn.at("upper").at("look") == "leather";
    if (has_leather_clothes) continue;
    // The shoe ends 1 dm above the ground, the sock 3 dm, of a body of 16 dm.
    const float dm = json.at("recipe").at("height_cm").get<float>() / 16;
    for (size_t f = 0; f < scan.face_count(); ++f) {
      float high = 0;
      for (uint32_t c = scan.face_begin[f]; c < scan.face_begin[f + 1]; ++c)
        high = std::max(high, scan.positions[scan.corners[c].position].y);
      if (high < 1.2f * dm)
        shoes += classes[f] == kLeather;
      else
        EXPECT_NE(classes[f], kLeather) << made.name << " at " << high;
      socks += high > 1.2f * dm && high < 3.2f * dm && classes[f] == kFabric;
    }
  }
  EXPECT_GT(shoes, 10u);
  EXPECT_GT(socks, 10u);
}

TEST(People, BalancedMeansHalfWomenAndSixGroups) {
  const TemporaryFolder folder;
  const TinyAssets tiny(folder / "assets");
  const Assets assets(folder / "assets", source_path("assets/wardrobe.json"));
  std::map<std::pair<bool, int>, int> counts;
  std::set<std::string> names;
  DrawOptions options;
  options.balanced = true;
  for (int i = 0; i < 144; ++i) {
    const Recipe recipe = draw_recipe(assets, options, i, 0);
    ++counts[{recipe.is_female, recipe.group}];
    names.insert(recipe.name);
    EXPECT_GE(recipe.years, 19);
    EXPECT_LE(recipe.years, 50);
    EXPECT_EQ(recipe.name, draw_recipe(assets, options, i, 3).name) << "redraws keep who it is";
  }
  EXPECT_EQ(counts.size(), 12u);
  for (const auto& [who, count] : counts) EXPECT_EQ(count, 12);
  EXPECT_EQ(names.size(), 144u);
}

TEST(People, WrongAssetsAreRefusedInOneLineAndLeaveNothing) {
  const TemporaryFolder folder;
  const auto fault = [&](const char* name, const std::string& text) {
    const fs::path assets = folder / "assets";
    fs::remove_all(assets);
    const TinyAssets tiny(assets);
    if (text == "missing")
      fs::remove_all(assets / name);
    else
      tiny.write(name, text);
    fs::remove_all(folder / "out");
    const std::string message = input_error_of([&] { make_people(job_of(assets, folder / "out", 2)); });
    if (fs::exists(folder / "out")) {
      for (const auto& entry : fs::directory_iterator(folder / "out"))
        EXPECT_EQ(entry.path().filename(), ".openhumanbrdf") << message;
    }
    return message;
  };
  expect_message(input_error_of([&] { make_people(job_of(folder / "none", folder / "out", 1)); }),
                 {"none", "not a folder"});
  expect_message(fault("3dobjs/base.obj", "missing"), {"base.obj", "not there"});
  expect_message(fault("3dobjs/base.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n"),
                 {"no group 'body'"});
  expect_message(fault("rigs/default.mhskel", "{"), {"default.mhskel", "not well-formed JSON"});
  expect_message(
      fault("rigs/default.mhskel", R"({"bones": {"a": {"head": "h", "tail": "h", "parent": "b"}}})"),
      {"default.mhskel", "bone 'a'", "parent 'b'"});
  expect_message(
      fault("rigs/default.mhskel",
            R"({"bones": {"a": {"head": "h", "tail": "h", "parent": "a"}}, "joints": {"h": [0]}})"),
      {"their own ancestors"});
  expect_message(fault("rigs/default_weights.mhw", R"({"weights": {"root": [[9999, 1]]}})"),
                 {"default_weights.mhw", "vertex 9999 of"});
  expect_message(fault("poses", "missing"), {"holds no pose"});
  expect_message(fault("poses/standing01.bvh", "HIERARCHY\n"), {"standing01.bvh", "no MOTION"});
  expect_message(fault("skins/young_caucasian_male", "missing"), {"holds no skin for men"});
  expect_message(fault("hair/short03", "missing"), {"holds no hair for women"});
  expect_message(fault("clothes/shoes01", "missing"), {"holds no shoes for women"});
  expect_message(fault("clothes/shoes01/m.mhmat", "diffuseTexture gone.png\n"), {"m.mhmat", "'gone.png'"});
  expect_message(fault("clothes/shoes01/m.mhmat", "diffuseTexture m.mhmat\n"), {"m.mhmat"});
  expect_message(fault("eyes/high-poly/high-poly.mhclo", "obj_file high-poly.obj\nverts 0\n0\n"),
                 {"high-poly.mhclo", "1 vertices are placed"});
}

TEST(People, AnOutputThatIsAFileIsRefused) {
  const TemporaryFolder folder;
  const TinyAssets assets(folder / "assets");
  write_file_atomically(folder / "out", "a file");
  input_error_of([&] { make_people(job_of(folder / "assets", folder / "out", 1)); });
}

TEST(People, HarderScansDifferAndAreJustAsGood) {
  const TemporaryFolder folder;
  const TinyAssets assets(folder / "assets");
  PeopleJob job = job_of(folder / "assets", folder / "plain", 1);
  const std::string name = make_people(job).people[0].name + "/";
  const auto scan_of = [&](const char* output, const ScanFaults& faults) {
    job.output = folder / output;
    job.scan.faults = faults;
    make_people(job);
    return files_of(job.output);
  };
  const auto plain = files_of(folder / "plain");
  const std::string obj = name + name.substr(0, name.size() - 1) + "_scan.obj",
                    jpg = name + name.substr(0, name.size() - 1) + "_scan.jpg";
  const auto noisy = scan_of("noisy", {.2f, 0, false}), holed = scan_of("holed", {0, 3, false}),
             shaded = scan_of("shaded", {0, 0, true});
  EXPECT_NE(noisy.at(obj), plain.at(obj));
  EXPECT_EQ(shaded.at(obj), plain.at(obj)) << "light changes the picture alone";
  EXPECT_NE(shaded.at(jpg), plain.at(jpg));
  EXPECT_LT(read_scan(folder / "holed" / obj).face_count(), read_scan(folder / "plain" / obj).face_count());
  EXPECT_EQ(scan_of("noisy_again", {.2f, 0, false}).at(obj), noisy.at(obj));
}

TEST(SharedAssets, TwoPeopleFromTheRealOnes) {
  OHB_SHARED_DATA_OR_SKIP(assets, "makehuman");
  const TemporaryFolder folder;
  PeopleJob job = job_of(assets, folder / "out", 2);
  job.scan.atlas_px = 1024;
  const PeopleReport report = make_people(job);
  for (const MadePerson& made : report.people) {
    const fs::path base = folder / "out" / made.name / (made.name + "_scan");
    const Scan scan = read_scan(base.string() + ".obj");
    EXPECT_GT(scan.face_count(), 8000u);
    const auto classes = read_face_classes(base.string() + ".labels.txt", scan.face_count(), {});
    EXPECT_EQ(classes.size(), scan.face_count());
  }
}

}  // namespace
}  // namespace ohb::people
