// Exports of samples that the test writes itself.
#include "dataset/exports/exports.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "dataset/exports/encodings.h"
#include "dataset/exports/sample_index.h"
#include "dataset/exports/tar.h"
#include "dataset/model/atomic_file.h"
#include "dataset/model/colour.h"
#include "dataset/model/sample.h"
#include "dataset/model/sample_listing.h"
#include "tests/support/test_files.h"

namespace ohb::exports {
namespace {
namespace fs = std::filesystem;

constexpr int kSize_px = 8;

Image ramp(int channels, float low, float high) {
  Image image(kSize_px, kSize_px, channels);
  for (size_t i = 0; i < image.values.size(); ++i)
    image.values[i] =
        low + (high - low) * static_cast<float>(i) / static_cast<float>(image.values.size() - 1);
  return image;
}

Sample sample_of(const std::string& person, int view, const std::string& light = "studio") {
  Sample sample;
  sample.mask = ramp(1, 1, 1);
  sample.mask.values[5] = 0;
  sample.normal = Image(kSize_px, kSize_px, 3);
  for (size_t i = 0; i < sample.normal.values.size(); i += 3)
    sample.normal.values[i + 1] = 0.6f, sample.normal.values[i + 2] = 0.8f;
  sample.diffuse = ramp(3, 0, 1), sample.roughness = ramp(1, 0, 1);
  sample.specular = ramp(1, 0, 0.3f), sample.sss = ramp(1, 0, 0.1f), sample.displacement = ramp(1, -30, 30);
  sample.classes = ramp(4, 0.25f, 0.25f);
  sample.lights = {{light, ramp(3, 0, 4)}};
  sample.attributes = {{"ohb:human", person}, {"ohb:displacementRange_cm", "50"}};
  sample.attributes.emplace_back("ohb:identity", identity_of(shared_attributes(sample.attributes)));
  sample.attributes.emplace_back("ohb:view", std::to_string(view));
  return sample;
}

/// A folder as `render` leaves it.
void write_views(const fs::path& folder, const std::string& person, int count,
                 const std::string& light = "studio") {
  fs::create_directories(folder);
  nlohmann::ordered_json json = {{"views", nlohmann::ordered_json::array()}};
  for (int view = 0; view < count; ++view) {
    const std::string name = "view_00" + std::to_string(view) + ".exr";
    const Sample sample = sample_of(person, view, light);
    write_sample(folder / name, sample);
    json["views"].push_back({{"file", name}});
    const ExrAttributes shared = shared_attributes(sample.attributes);
    json["identity"] = identity_of(shared);
    for (const auto& [key, value] : shared) json["settings"][key] = value;
  }
  write_file_atomically(folder / "render.json", json.dump());
}

ExportJob job_of(const fs::path& input, const fs::path& output, Form form) {
  ExportJob job;
  job.input = input, job.output = output, job.form = form;
  job.quiet = true;
  return job;
}

TEST(Exports, PngValuesAreWithinHalfAStepOfTheSample) {
  const TemporaryFolder folder;
  write_views(folder / "ann", "ann", 1);
  const Sample sample = read_sample(folder / "ann/view_000.exr");
  for (const int bits : {8, 16}) {
    ExportJob job = job_of(folder / "ann", folder / "png", Form::kPng);
    job.bits = bits;
    export_samples(job);
    const float half_step = 0.5f / static_cast<float>((1 << bits) - 1) + 1e-6f;
    const fs::path set = folder / "png/samples/ann/view_000";
    const auto compare = [&](const std::string& name, const Image& image, auto decode, float tolerance) {
      const Image read = read_image(set / (name + ".png"));
      ASSERT_EQ(read.channels, image.channels) << name;
      const auto channels = static_cast<size_t>(image.channels);
      for (size_t i = 0; i < image.values.size(); ++i) {
        if (sample.mask.values[i / channels] == 0)
          EXPECT_EQ(read.values[i], 0) << name;
        else
          EXPECT_NEAR(decode(read.values[i]), image.values[i], tolerance) << name << " " << i;
      }
    };
    const auto plain = [](float v) { return v; };
    compare("mask", sample.mask, plain, half_step);
    compare("roughness", sample.roughness, plain, half_step);
    compare("specular", sample.specular, plain, half_step);
    compare("sss", sample.sss, plain, half_step);
    compare(
        "normal", sample.normal, [](float v) { return 2 * v - 1; }, 2 * half_step);
    compare(
        "displacement", sample.displacement, [](float v) { return (2 * v - 1) * 50; },
        100 * half_step + 1e-4f);
    compare(
        "diffuse", sample.diffuse, [](float v) { return srgb_to_linear(v); }, 2.3f * half_step);
    EXPECT_NE(read_file(folder / "png/README.md").find(std::to_string(bits) + " bits"), std::string::npos);
  }
}

TEST(Exports, TheSameBytesForAnyNumberOfThreads) {
  const TemporaryFolder folder;
  write_views(folder / "in/ann", "ann", 3);
  write_views(folder / "in/bob", "bob", 2);
  for (const Form form : {Form::kPng, Form::kWebDataset, Form::kPage}) {
    export_samples(job_of(folder / "in", folder / "many", form));
    {
      const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
      export_samples(job_of(folder / "in", folder / "one", form));
    }
    size_t compared = 0;
    for (const auto& entry : fs::recursive_directory_iterator(folder / "many"))
      if (entry.is_regular_file()) {
        const fs::path other = folder / "one" / entry.path().lexically_relative(folder / "many").string();
        EXPECT_EQ(read_file(entry.path()), read_file(other)) << other;
        ++compared;
      }
    EXPECT_GE(compared, 3u);
    fs::remove_all(folder / "one"), fs::remove_all(folder / "many");
  }
}

TEST(Exports, ShardsHoldTheSamplesAsTheyAre) {
  const TemporaryFolder folder;
  write_views(folder / "in/a.b", "a.b", 3);
  ExportJob job = job_of(folder / "in", folder / "out", Form::kWebDataset);
  job.samples_a_shard = 2;
  EXPECT_EQ(export_samples(job).files, 3u);
  const std::string sample = read_file(folder / "in/a.b/view_000.exr");
  const std::string shard = read_file(folder / "out/samples-000000.tar");
  EXPECT_EQ(shard.substr(0, 18), "a%2eb_view_000.exr");
  EXPECT_EQ(shard.substr(512, sample.size()), sample);
  EXPECT_EQ(shard.size() % 512, 0u);
  EXPECT_TRUE(fs::exists(folder / "out/samples-000001.tar"));
  expect_message(input_error_of([] { tar_member(std::string(101, 'a'), ""); }), {"tar"});
}

TEST(Exports, ADatasetsSplitsAndAttributesAreKept) {
  const TemporaryFolder folder;
  write_views(folder / "in/humans/ann/views", "ann", 2);
  const std::string person =
      R"(<dataset schema="1" name="d"><people><person id="ann" split="train" sex="female" )"
      R"(model="humans/ann/model" views="humans/ann/views" model_identity="x" )";
  write_file_atomically(folder / "in/dataset.xml",
                        person + R"(sets="2" planned_sets="2"/></people></dataset>)");
  const SampleIndex index = index_samples(folder / "in");
  EXPECT_EQ(index.people.at(0).split, "train");
  EXPECT_EQ(index.people.at(0).attributes.at("sex"), "female");
  EXPECT_EQ(index.people.at(0).attributes.size(), 1u);
  export_samples(job_of(folder / "in", folder / "page", Form::kPage));
  EXPECT_NE(read_file(folder / "page/CARD.md").find("| female | 1 | 100.0 % |"), std::string::npos);

  const std::vector<std::pair<std::string, std::string>> refused = {
      {person + R"(sets="1" planned_sets="2"/></people></dataset>)", "1 of 2 sets"},
      {R"(<dataset schema="7"><people/></dataset>)", "newer"},
      {R"(<dataset schema="1"><people><person id="a" split="train" views="../x" sets="1" planned_sets="1"/></people></dataset>)",
       "leaves the dataset"},
      {R"(<dataset schema="1"><people/></dataset>)", "no samples"},
      {R"(<dataset schema="1"><people><person id="a" split="t" views="gone" sets="1" planned_sets="1"/></people></dataset>)",
       "render.json"},
      {"<dataset", "well-formed"}};
  for (const auto& [text, words] : refused) {
    write_file_atomically(folder / "in/dataset.xml", text);
    expect_message(input_error_of([&] { export_samples(job_of(folder / "in", folder / "out", Form::kPng)); }),
                   {words});
    EXPECT_FALSE(fs::exists(folder / "out"));
  }
}

TEST(Exports, MixedAndUnfinishedFoldersAreRefused) {
  const TemporaryFolder folder;
  const auto refusal = [&] {
    return input_error_of([&] { export_samples(job_of(folder / "in", folder / "out", Form::kPng)); });
  };
  expect_message(refusal(), {"no such folder"});
  write_views(folder / "in/ann", "ann", 2);
  write_sample(folder / "in/ann/view_007.exr", sample_of("ann", 7));
  expect_message(refusal(), {"view_007.exr", "not listed"});
  fs::remove(folder / "in/ann/view_007.exr");
  write_sample(folder / "in/ann/view_001.exr", sample_of("bob", 1));
  expect_message(refusal(), {"view_001.exr", "other settings"});
  fs::remove(folder / "in/ann/view_001.exr");
  expect_message(refusal(), {"view_001.exr", "missing"});
  fs::remove(folder / "in/ann/render.json");
  expect_message(refusal(), {"no render.json"});
  fs::remove_all(folder / "in");
  write_views(folder / "in/one", "ann", 1);
  write_views(folder / "in/two", "ann", 1);
  expect_message(refusal(), {"second folder", "ann"});
  EXPECT_FALSE(fs::exists(folder / "out"));
}

TEST(Exports, NamesThatLeaveTheFolderAreRefused) {
  const TemporaryFolder folder;
  write_views(folder / "in", "../up", 1);
  const auto refusal = [&] {
    return input_error_of([&] { export_samples(job_of(folder / "in", folder / "out", Form::kPng)); });
  };
  expect_message(refusal(), {"names no folder"});
  fs::remove_all(folder / "in");
  write_views(folder / "in", "ann", 1, "/../../up");
  expect_message(refusal(), {"names no file"});
  EXPECT_FALSE(fs::exists(folder / "out"));
}

TEST(Exports, ANameInThePageCannotEndItsScript) {
  const TemporaryFolder folder;
  write_views(folder / "in", "<script>x", 1);
  export_samples(job_of(folder / "in", folder / "page", Form::kPage));
  EXPECT_EQ(read_file(folder / "page/data.js").find('<'), std::string::npos);
}

TEST(Exports, ASamplesFolderIsNoPlaceForItsExport) {
  const TemporaryFolder folder;
  write_views(folder / "in/ann", "ann", 1);
  expect_message(input_error_of([&] { export_samples(job_of(folder / "in", folder / "in", Form::kPng)); }),
                 {"in"});
  EXPECT_TRUE(fs::exists(folder / "in/ann/view_000.exr"));
}

}  // namespace
}  // namespace ohb::exports
