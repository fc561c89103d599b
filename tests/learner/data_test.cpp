// Samples to tensors, the split by person, and the loader's order.
#include "learner/data.h"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "dataset/model/atomic_file.h"
#include "dataset/model/colour.h"
#include "dataset/model/sample_listing.h"
#include "learner/loader.h"
#include "test_samples.h"
#include "tests/support/test_files.h"

namespace ohb {
using namespace learner;
namespace {

using torch::Tensor;

float value_at(const Tensor& map, int channel, int y, int x) {
  return map[0][channel][y][x].item<float>();
}

TEST(Example, FollowsTheConventions) {
  const Sample sample = ball_sample(32, "ada", 0);
  const Example e = example_of(sample, "view_000.exr", 1, 32);
  EXPECT_EQ(e.person, "ada");
  EXPECT_EQ(e.name, "view_000.exr under right");
  EXPECT_EQ(e.input.sizes(), (std::vector<int64_t>{1, 4, 32, 32}));
  EXPECT_EQ(e.mask.sizes(), (std::vector<int64_t>{1, 1, 32, 32}));
  // Rows run from the top, +Y is up: the normals of the upper half point up.
  EXPECT_GT(value_at(e.truth.normal, 1, 8, 16), 0);
  EXPECT_GT(value_at(e.truth.normal, 0, 16, 24), 0);
  // 100 cm of half frame: the displacement is in half frames.
  EXPECT_NEAR(value_at(e.truth.displacement, 0, 16, 16), sample.displacement.pixel(16, 16)[0] / 100, 1e-6);
  EXPECT_EQ(e.half_frame_cm, 100);
  EXPECT_EQ(value_at(e.truth.diffuse, 2, 16, 16), sample.diffuse.pixel(16, 16)[2]);
  // Background: colour and mask are -1, maps 0.
  for (int c = 0; c < 4; ++c) EXPECT_EQ(value_at(e.input, c, 0, 0), -1);
  EXPECT_EQ(value_at(e.truth.roughness, 0, 0, 0), 0);
  EXPECT_EQ(value_at(e.input, 3, 16, 16), 1);
}

TEST(Example, ExposesAsACameraWould) {
  Sample sample = ball_sample(32, "ada", 0);
  const Tensor once = example_of(sample, "f", 0, 32).input;
  for (float& v : sample.lights[0].radiance.values) v *= 37;
  EXPECT_TRUE(torch::allclose(example_of(sample, "f", 0, 32).input, once, 1e-5, 1e-5))
      << "exposure takes the level out";
  // A foreground of one radiance is exposed to 0.8.
  for (size_t i = 0; i < sample.lights[0].radiance.values.size(); ++i)
    sample.lights[0].radiance.values[i] = sample.mask.values[i / 3] * 3;
  EXPECT_NEAR(value_at(example_of(sample, "f", 0, 32).input, 0, 16, 16), 2 * linear_to_srgb(0.8f) - 1, 1e-5);
}

TEST(Example, AveragesDownByCoverage) {
  Sample sample = ball_sample(32, "ada", 0);
  // Two pixels of one block: one fully covered, one a quarter, the rest background.
  for (int y = 16; y < 18; ++y)
    for (int x = 16; x < 18; ++x) sample.mask.pixel(x, y)[0] = 0;
  sample.mask.pixel(16, 16)[0] = 1;
  sample.mask.pixel(17, 16)[0] = 0.25f;
  sample.roughness.pixel(16, 16)[0] = 0.4f;
  sample.roughness.pixel(17, 16)[0] = 0.9f;
  const Example e = example_of(sample, "f", 0, 16);
  EXPECT_NEAR(value_at(e.mask, 0, 8, 8), 1.25f / 4, 1e-6);
  EXPECT_NEAR(value_at(e.truth.roughness, 0, 8, 8), (0.4f + 0.25f * 0.9f) / 1.25f, 1e-6);
}

TEST(Example, RefusesWhatIsWrongInWords) {
  const auto message = [](Sample sample, int size = 32) {
    return input_error_of([&] { example_of(sample, "view_003.exr", 0, size); });
  };
  Sample good = ball_sample(32, "ada", 0), s = good;
  expect_message(message(good, 48), {"view_003.exr", "32 x 32", "--size 48"});
  expect_message(message(good, 20), {"no whole multiple"});
  s.lights.clear();
  expect_message(message(s), {"no lit image"});
  s = good;
  s.mask = Image(32, 32, 1);
  expect_message(message(s), {"covers nothing"});
  s = good;
  s.attributes = {{"ohb:human", "ada"}};
  expect_message(message(s), {"ohb:displacementRange_cm", "missing"});
  s.attributes = {{"ohb:displacementRange_cm", "-3"}};
  expect_message(message(s), {"'-3'"});
  s = good;
  s.lights[0].radiance = Image(32, 32, 3);
  expect_message(message(s), {"view_003.exr under left", "black"});
  s = good;
  for (int c = 0; c < 3; ++c) s.normal.pixel(16, 16)[c] = 0;
  expect_message(message(s), {"normal", "(16, 16)", "length 0"});
}

TEST(Dataset, IsReadBySubFolder) {
  TemporaryFolder folder;
  write_ball_dataset(folder.path(), 3, 2, 16);
  const Dataset dataset = read_dataset(folder.path());
  ASSERT_EQ(dataset.people.size(), 3u);
  EXPECT_EQ(dataset.people[1].name, "person1");
  EXPECT_EQ(dataset.people[1].views.size(), 2u);
}

/// What render writes beside the views.
void write_listing(const std::filesystem::path& folder, const ExrAttributes& settings,
                   const std::vector<std::string>& views) {
  nlohmann::ordered_json json = {{"identity", identity_of(settings)}};
  for (const auto& [name, value] : settings) json["settings"][name] = value;
  for (const std::string& view : views) json["views"].push_back({{"file", view}});
  write_file_atomically(folder / "render.json", json.dump());
}

TEST(Dataset, ReadsOnlyViewsThatBelong) {
  TemporaryFolder folder;
  write_ball_dataset(folder.path(), 1, 4, 16);
  const auto person = folder / "person0";
  const ExrAttributes settings = shared_attributes(read_sample(person / "view_000.exr").attributes);
  write_listing(person, settings, {"view_000.exr", "view_001.exr", "view_003.exr"});
  // View 2 is not listed, view 3 is another person's, and one is no picture at all.
  write_sample(person / "view_003.exr", ball_sample(16, "somebody else", 3));
  write_file_atomically(person / "view_004.exr", std::string("notes"));
  const Dataset dataset = read_dataset(folder.path());
  ASSERT_EQ(dataset.people.size(), 1u);
  EXPECT_EQ(dataset.people[0].views,
            (std::vector<std::filesystem::path>{person / "view_000.exr", person / "view_001.exr"}));
  // The same views of other settings are another dataset.
  const std::string identity = identity_of_views(dataset, {"person0"});
  EXPECT_EQ(identity_of_views(read_dataset(folder.path()), {"person0"}), identity);
  write_listing(person, settings, {"view_000.exr"});
  EXPECT_NE(identity_of_views(read_dataset(folder.path()), {"person0"}), identity);
}

TEST(Dataset, WithoutAListingTheViewsMustAgree) {
  TemporaryFolder folder;
  write_ball_dataset(folder.path(), 1, 2, 16);
  write_sample(folder / "person0" / "view_002.exr", ball_sample(16, "somebody else", 2));
  expect_message(input_error_of([&] { read_dataset(folder.path()); }),
                 {"view_002.exr", "ohb:human", "view_000.exr", "different settings"});
}

TEST(Dataset, RefusesWhatIsWrongInWords) {
  TemporaryFolder folder;
  expect_message(input_error_of([&] { read_dataset(folder / "none"); }), {"none", "no such folder"});
  expect_message(input_error_of([&] { read_dataset(folder.path()); }), {"holds no view_*.exr"});
  write_ball_dataset(folder.path(), 1, 1, 16);
  std::filesystem::resize_file(folder / "person0" / "view_000.exr", 500);
  expect_message(input_error_of([&] { read_dataset(folder.path()); }), {"view_000.exr"});
  std::ofstream(folder / "person0" / "view_000.exr") << "hello";
  expect_message(input_error_of([&] { read_dataset(folder.path()); }), {"view_000.exr", "no PNG"});
}

TEST(Dataset, NaNInASampleIsNamedWithItsPixel) {
  TemporaryFolder folder;
  Sample sample = ball_sample(16, "ada", 0);
  sample.displacement.pixel(5, 7)[0] = std::nanf("");
  write_sample(folder / "view_000.exr", sample);
  expect_message(input_error_of([&] { read_example(folder / "view_000.exr", 0, 16); }),
                 {"view_000.exr", "displacement", "(5, 7)", "NaN"});
}

TEST(Split, NeverPutsAPersonOnBothSides) {
  Dataset dataset{"data", {}};
  for (int i = 0; i < 8; ++i) dataset.people.push_back({"p" + std::to_string(i), {"view_000.exr"}});
  const Split split = split_people(dataset, {}, 3);
  EXPECT_EQ(split.training.size(), 6u);
  EXPECT_EQ(split.held_out.size(), 2u);
  std::set<std::string> all(split.training.begin(), split.training.end());
  all.insert(split.held_out.begin(), split.held_out.end());
  EXPECT_EQ(all.size(), 8u);
  EXPECT_EQ(split_people(dataset, {}, 3).held_out, split.held_out);
  EXPECT_EQ(split_people(dataset, {"p5", "p1"}, 3).held_out, (std::vector<std::string>{"p1", "p5"}));
  expect_message(input_error_of([&] { split_people(dataset, {"nobody"}, 3); }), {"nobody"});
  // One person: nobody can be held out, and training still works.
  dataset.people.resize(1);
  EXPECT_EQ(split_people(dataset, {}, 3).training.size(), 1u);
  expect_message(input_error_of([&] { split_people(dataset, {"p0"}, 3); }), {"nobody is left"});
}

TEST(Loader, VisitsEachViewOnceAnEpochInAnOrderOfTheSeed) {
  std::vector<std::vector<size_t>> epochs(2);
  for (uint64_t p = 0; p < 20; ++p) epochs[p / 10].push_back(draw_at(4, p, 10).view);
  EXPECT_EQ(std::set<size_t>(epochs[0].begin(), epochs[0].end()).size(), 10u);
  EXPECT_EQ(std::set<size_t>(epochs[1].begin(), epochs[1].end()).size(), 10u);
  EXPECT_NE(epochs[0], epochs[1]);
  EXPECT_EQ(draw_at(4, 13, 10).view, epochs[1][3]);
  EXPECT_NE(draw_at(4, 13, 10).light_key, draw_at(5, 13, 10).light_key);
}

TEST(Loader, GivesTheSameExamplesForAnyThreadsAndAnyStart) {
  TemporaryFolder folder;
  write_ball_dataset(folder.path(), 2, 3, 16);
  const Dataset dataset = read_dataset(folder.path());
  const auto views = views_of(dataset, {"person0", "person1"});
  ASSERT_EQ(views.size(), 6u);
  Loader one(views, {16, 9, 0, 1, 2}), three(views, {16, 9, 0, 3, 5});
  std::vector<Example> examples;
  for (int i = 0; i < 15; ++i) {
    examples.push_back(one.next());
    const Example same = three.next();
    EXPECT_EQ(same.name, examples.back().name);
    EXPECT_TRUE(same.input.equal(examples.back().input));
  }
  Loader later(views, {16, 9, 11, 2, 2});
  for (int i = 11; i < 15; ++i) EXPECT_EQ(later.next().name, examples[i].name);
}

TEST(Loader, HandsOverTheErrorOfTheFileItFailedOn) {
  TemporaryFolder folder;
  write_ball_dataset(folder.path(), 1, 3, 16);
  const Dataset dataset = read_dataset(folder.path());
  std::filesystem::resize_file(folder / "person0" / "view_002.exr", 700);
  Loader loader(views_of(dataset, {"person0"}), {16, 1, 0, 2, 4});
  expect_message(input_error_of([&] {
                   for (int i = 0; i < 3; ++i) loader.next();
                 }),
                 {"view_002.exr"});
  expect_message(input_error_of([] { Loader({}, {}); }), {"no view"});
}

}  // namespace
}  // namespace ohb
