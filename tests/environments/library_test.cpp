// Import and the library: what is mended, refused, kept.
#include <OpenEXR/ImfRgbaFile.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <fstream>
#include <limits>

#include "dataset/environments/import.h"
#include "dataset/environments/panorama.h"
#include "dataset/environments/synthesise.h"
#include "dataset/model/atomic_file.h"
#include "dataset/model/colour.h"
#include "dataset/model/environment.h"
#include "tests/support/test_files.h"

namespace ohb::environments {
namespace {
namespace fs = std::filesystem;

constexpr float kInfinite = std::numeric_limits<float>::infinity();

Image grey(int width_px, int height_px, float value = 0.5f) {
  Image image(width_px, height_px, 3);
  std::fill(image.values.begin(), image.values.end(), value);
  return image;
}

fs::path write_map(const fs::path& file, const Image& image, ExrPart::Type type = ExrPart::Type::kFloat) {
  write_exr(file, {{"", {"R", "G", "B"}, type, image}}, {});
  return file;
}

ImportJob job_of(const TemporaryFolder& folder, std::vector<fs::path> files) {
  ImportJob job;
  job.files = std::move(files);
  job.library = folder / "lights";
  job.licence = "CC0-1.0", job.source = "a test";
  job.quiet = true;
  return job;
}

TEST(Import, ASunAboveHalfRangeKeepsItsEnergy) {
  const TemporaryFolder folder;
  Image image = grey(128, 64);
  for (int c = 0; c < 3; ++c) image.pixel(40, 20)[c] = 2e6f;
  const fs::path file = write_map(folder / "Sunny Day.exr", image);
  ImportJob job = job_of(folder, {file});
  job.width_px = 64;
  const LibraryEntry entry = import_environments(job).items.at(0).entry;
  EXPECT_EQ(entry.id, "sunny_day");
  EXPECT_EQ(entry.values, "float");
  const Environment read = read_environment(map_file(job.library, entry));
  const std::array<double, 3> before = energy_of(image), after = energy_of(read.radiance);
  for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(after[c] / before[c], 1, 1e-6);
  EXPECT_EQ(read.sha256, entry.sha256);
  EXPECT_GT(dot(brightest_direction(read), entry.light.brightest), 0.9999f);
  EXPECT_GT(entry.light.peak, 4e5);
}

TEST(Import, HalvesKeepTheEnergyWithinTheStatedTolerance) {
  const TemporaryFolder folder;
  Image image = grey(256, 128);
  for (size_t i = 0; i < image.values.size(); ++i)
    image.values[i] = 0.001f + static_cast<float>(i % 977) * 0.01f;
  ImportJob job = job_of(folder, {write_map(folder / "a.exr", image)});
  const LibraryEntry entry = import_environments(job).items.at(0).entry;
  EXPECT_EQ(entry.values, "half");
  const std::array<double, 3> before = energy_of(image),
                              after = energy_of(read_environment(map_file(job.library, entry)).radiance);
  for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(after[c] / before[c], 1, kHalfTolerance);
}

TEST(Import, MendsAndCountsWhatIsNoRadiance) {
  const TemporaryFolder folder;
  Image image = grey(64, 32, 2);
  image.pixel(10, 10)[1] = std::nanf("");
  image.pixel(0, 3)[0] = -kInfinite;
  image.pixel(30, 5)[0] = image.pixel(30, 5)[1] = kInfinite;
  image.pixel(50, 20)[2] = -0.25f;
  const Panorama panorama = read_panorama(write_map(folder / "bad.exr", image));
  EXPECT_EQ(panorama.nan, 2u);
  EXPECT_EQ(panorama.infinite, 1u);
  EXPECT_EQ(panorama.negative, 1u);
  EXPECT_EQ(panorama.warnings.size(), 3u);
  EXPECT_FLOAT_EQ(panorama.radiance.pixel(10, 10)[1], 2);
  EXPECT_FLOAT_EQ(panorama.radiance.pixel(0, 3)[0], 2);
  EXPECT_FLOAT_EQ(panorama.radiance.pixel(30, 5)[0], 65504);
  EXPECT_FLOAT_EQ(panorama.radiance.pixel(30, 5)[2], 2);
  EXPECT_FLOAT_EQ(panorama.radiance.pixel(50, 20)[2], 0);
}

TEST(Import, BytesAreDecodedFromSrgbWithAWarning) {
  const TemporaryFolder folder;
  write_png(folder / "sky.png", grey(32, 16, 128.0f / 255));
  const Panorama panorama = read_panorama(folder / "sky.png");
  EXPECT_NEAR(panorama.radiance.values[0], 0.2158f, 1e-3f);
  ASSERT_EQ(panorama.warnings.size(), 1u);
  expect_message(panorama.warnings[0], {"8-bit", "no sun"});
}

TEST(Import, StatedPrimariesAreConverted) {
  const TemporaryFolder folder;
  const fs::path file = folder / "aces.exr";
  {
    Imf::Header header(32, 16);
    Imf::addChromaticities(header, Imf::Chromaticities({0.713f, 0.293f}, {0.165f, 0.830f}, {0.128f, 0.044f},
                                                       {0.32168f, 0.33767f}));
    Imf::RgbaOutputFile out(file.c_str(), header, Imf::WRITE_RGB);
    const std::vector<Imf::Rgba> pixels(32 * 16, Imf::Rgba(0.6f, 0.4f, 0.3f));
    out.setFrameBuffer(pixels.data(), 1, 32);
    out.writePixels(16);
  }
  const Panorama panorama = read_panorama(file);
  ASSERT_EQ(panorama.warnings.size(), 1u);
  // By the published AP1 to Rec. 709 matrix: 1.70508, -0.62179, -0.08326.
  EXPECT_NEAR(panorama.radiance.values[0], 0.6f * 1.70508f - 0.4f * 0.62179f - 0.3f * 0.08326f, 2e-3f);
}

struct Refusal {
  const char* name;
  Image image;
  std::vector<std::string> words;
};

TEST(Import, RefusesInOneLine) {
  Image black = grey(32, 16, 0), nan = grey(32, 16), negative = grey(32, 16);
  for (int x = 0; x < 32; ++x) nan.pixel(x, 4)[0] = std::nanf(""), negative.pixel(x, 4)[0] = -1;
  const std::vector<Refusal> refusals = {
      {"black.exr", black, {"all black"}},
      {"nan.exr", nan, {"texel (0, 4)", "32 of 512", "more than 1 %"}},
      {"negative.exr", negative, {"negative", "more than 1 %"}},
      {"side.exr", grey(16, 32), {"16 x 32", "lies on its side"}},
      {"ball.exr", grey(32, 32), {"mirror ball"}},
      {"cube.exr", grey(48, 36), {"cube"}},
      {"strip.exr", grey(96, 16), {"cube"}},
      {"wide.exr", grey(35, 16), {"2:1"}},
  };
  for (const Refusal& refusal : refusals) {
    const TemporaryFolder folder;
    const fs::path file = write_map(folder / refusal.name, refusal.image);
    const std::string message = input_error_of([&] { import_environments(job_of(folder, {file})); });
    expect_message(message, {refusal.name});
    for (const std::string& word : refusal.words) expect_message(message, {word});
    EXPECT_FALSE(fs::exists(folder / "lights")) << refusal.name;
  }
}

TEST(Import, RefusesMalformedFilesInOneLine) {
  const TemporaryFolder folder;
  const std::string whole = read_file(write_map(folder / "whole.exr", grey(64, 32)));
  const std::vector<std::pair<std::string, std::string>> files = {
      {"empty.exr", ""},
      {"cut.exr", whole.substr(0, whole.size() / 3)},
      {"head.exr", whole.substr(0, 20)},
      {"text.hdr", "hello"},
      {"pointer.exr", "version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 12\n"},
      {"magic.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n"},
      {"lying.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 30000 +X 60000\n"},
      {"xyz.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 2 +X 4\n"},
  };
  for (const auto& [name, bytes] : files) {
    write_file_atomically(folder / name, bytes);
    const std::string message = input_error_of([&] { import_environments(job_of(folder, {folder / name})); });
    expect_message(message, {name});
  }
  const std::string message =
      input_error_of([&] { import_environments(job_of(folder, {folder / "nowhere.exr"})); });
  expect_message(message, {"nowhere.exr"});
}

TEST(Import, ALicenceIsNeededAndMayStandBeside) {
  const TemporaryFolder folder;
  const fs::path file = write_map(folder / "street.exr", grey(32, 16));
  ImportJob job = job_of(folder, {file});
  job.licence = "";
  expect_message(input_error_of([&] { import_environments(job); }),
                 {"street.exr", "no licence", "--licence"});
  write_file_atomically(folder / "street.exr.json", R"({"licence": "CC-BY-4.0", "source": "there"})");
  EXPECT_EQ(import_environments(job).items.at(0).entry.licence, "CC-BY-4.0");
  write_file_atomically(folder / "street.exr.json", R"({"licence": 3})");
  expect_message(input_error_of([&] { import_environments(job); }), {"street.exr.json", "licence"});
  write_file_atomically(folder / "street.exr.json", "[]");
  expect_message(input_error_of([&] { import_environments(job); }), {"street.exr.json", "JSON object"});
}

TEST(Import, GoodFilesAreImportedBesideBadOnes) {
  const TemporaryFolder folder;
  const fs::path bad = write_map(folder / "bad.exr", grey(32, 16, 0)),
                 good = write_map(folder / "good.exr", grey(32, 16));
  expect_message(input_error_of([&] { import_environments(job_of(folder, {bad, good})); }), {"bad.exr"});
  const auto entries = read_library(folder / "lights");
  ASSERT_EQ(entries.size(), 1u);
  EXPECT_EQ(entries[0].id, "good");
}

TEST(Library, KeepsWhatIsThereAndMakesAgainWhatIsNot) {
  const TemporaryFolder folder;
  const fs::path one = write_map(folder / "one.exr", grey(32, 16)),
                 two = write_map(folder / "two.exr", grey(32, 16, 2));
  import_environments(job_of(folder, {one}));
  const std::string list = read_file(folder / "lights/envmaps.xml");
  LibraryChange change = import_environments(job_of(folder, {one, two}));
  EXPECT_TRUE(change.items.at(0).was_there);
  EXPECT_FALSE(change.items.at(1).was_there);
  EXPECT_NE(read_file(folder / "lights/envmaps.xml"), list);
  const std::string map = read_file(folder / "lights/envmaps/one.exr");
  std::ofstream(folder / "lights/envmaps/one.exr", std::ios::app) << "x";
  EXPECT_NE(damage_of(folder / "lights", read_library(folder / "lights").at(0)), "");
  change = import_environments(job_of(folder, {one, two}));
  EXPECT_FALSE(change.items.at(0).was_there);
  EXPECT_EQ(read_file(folder / "lights/envmaps/one.exr"), map);
}

TEST(Library, TwoPicturesOfOneNameAreBothKept) {
  const TemporaryFolder folder;
  fs::create_directories(folder / "other");
  const fs::path one = write_map(folder / "env.exr", grey(32, 16)),
                 two = write_map(folder / "other" / "ENV.exr", grey(32, 16, 2));
  const LibraryChange change = import_environments(job_of(folder, {one, two}));
  EXPECT_EQ(change.items.at(0).entry.id, "env");
  EXPECT_EQ(change.items.at(1).entry.id.substr(0, 4), "env_");
  EXPECT_EQ(read_library(folder / "lights").size(), 2u);
}

TEST(Library, SomebodysOwnFileIsNotOverwritten) {
  const TemporaryFolder folder;
  import_environments(job_of(folder, {write_map(folder / "one.exr", grey(32, 16))}));
  write_map(folder / "lights/envmaps/two.exr", grey(8, 4));
  const fs::path two = write_map(folder / "two.exr", grey(32, 16, 2));
  expect_message(input_error_of([&] { import_environments(job_of(folder, {two})); }),
                 {"two.exr", "in the way"});
}

TEST(Library, DamagedListsAreRefusedWithTheirLine) {
  const TemporaryFolder folder;
  import_environments(job_of(folder, {write_map(folder / "one.exr", grey(32, 16))}));
  const fs::path list = folder / "lights/envmaps.xml";
  const std::string good = read_file(list);
  const std::vector<std::pair<std::string, std::string>> changes = {
      {"id=\"one\"", "id=\"../one\""},  {"version=\"1\" radiance", "version=\"2\" radiance"},
      {"width=\"32\"", "width=\"x\""},  {"bytes=", "bites="},
      {"peak=\"", "peak=\"nan"},        {"</environments>", ""},
      {"licence=", "id=\"a\" licence="}};
  for (const auto& [from, to] : changes) {
    std::string bad = good;
    ASSERT_NE(bad.find(from), std::string::npos) << from;
    bad.replace(bad.find(from), from.size(), to);
    write_file_atomically(list, bad);
    expect_message(input_error_of([&] { read_library(folder / "lights"); }), {"envmaps.xml"});
  }
  expect_message(input_error_of([&] { read_library(folder.path()); }), {"no environment library"});
}

TEST(Library, ASecondWriterIsToldToWait) {
  const TemporaryFolder folder;
  const LibraryWriter first(folder / "lights");
  EXPECT_THROW(LibraryWriter(folder / "lights"), TryAgainError);
}

TEST(Library, SynthesisHasTheSameBytesForAnyCountAndThreads) {
  const TemporaryFolder folder;
  SynthesisJob job;
  job.width_px = 32, job.quiet = true;
  job.count = 10, job.library = folder / "ten";
  {
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    synthesise_environments(job);
  }
  job.count = 12, job.library = folder / "twelve";
  const LibraryChange change = synthesise_environments(job);
  for (size_t k = 0; k < 10; ++k) {
    const std::string file = "envmaps/" + change.items[k].entry.id + ".exr";
    EXPECT_EQ(read_file(folder / ("ten/" + file)), read_file(folder / ("twelve/" + file))) << file;
  }
  EXPECT_TRUE(synthesise_environments(job).items.at(11).was_there);
  for (const LibraryEntry& entry : read_library(job.library))
    EXPECT_NO_THROW(read_environment(map_file(job.library, entry))) << entry.id;
}

}  // namespace
}  // namespace ohb::environments
