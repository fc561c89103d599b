// The verdict of a validation, and its files.
#include "renderer/validation/report.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <regex>

#include "dataset/model/atomic_file.h"
#include "renderer/validation/pictures.h"
#include "tests/support/test_files.h"

namespace ohb {
using namespace renderer;
using namespace validation;
namespace {

RegionResult region(const std::string& name, double value, double reach, double pixels = 1000) {
  RegionResult result{{}, {8, 128, 128}};
  result.ratio.name = name;
  result.ratio.weight_px = pixels;
  result.ratio.total = {value, value - reach, value + reach};
  return result;
}

/// A validation that passes, of 12 x 12 px.
Validation good() {
  constexpr int kSize = 12;
  Validation v;
  v.model_name = "<person & co>";
  v.environment_name = "studio";
  v.blender_version = "3.4.1";
  v.blender_settings = {{"scene.cycles.samples", "128", "128", true}};
  v.coverage = Image(kSize, kSize, 1);
  for (int y = 3; y < 9; ++y)
    for (int x = 3; x < 9; ++x) v.coverage.pixel(x, y)[0] = 1;
  v.pixels = pixel_sets(v.coverage, v.coverage);
  for (Moments* side : {&v.ours, &v.cycles}) {
    side->mean = side->variance = Image(kSize, kSize, 3);
    for (size_t i = 0; i < side->mean.values.size(); ++i) {
      side->mean.values[i] = 0.5f * v.coverage.values[i / 3];
      side->variance.values[i] = 0.01f * v.coverage.values[i / 3];
    }
  }
  v.regions = {region("skin", 1.0005, 0.001), region("whole image", 1, 0.0005)};
  v.band = region("outline", 1.02, 0.03);
  v.inside_bins.bins = v.inside_bins.accepted = 4;
  v.inside_bins.z = v.band_bins.z = Image(kSize, kSize, 1);
  v.our_cost = {0.5, 1, 2, 0.01};
  v.cycles_cost = {2, 3, 6, 0.02};
  return v;
}

TEST(Verdict, Passes) {
  const Verdict verdict = judge(good());
  EXPECT_EQ(verdict.outcome, Outcome::kPass);
  EXPECT_EQ(verdict.reasons.size(), 1u);
}

TEST(Verdict, FindsABiasedRegion) {
  Validation v = good();
  v.regions[0] = region("skin", 1.012, 0.002);
  const Verdict verdict = judge(v);
  EXPECT_EQ(verdict.outcome, Outcome::kDifference);
  EXPECT_NE(verdict.reasons[0].find("skin: ours / Cycles - 1 is +1.200 %"), std::string::npos)
      << verdict.reasons[0];
}

TEST(Verdict, WideIntervalsAndFewSeedsAreUndecided) {
  Validation v = good();
  v.regions[0] = region("hair", 1.001, 0.01);
  EXPECT_EQ(judge(v).outcome, Outcome::kUndecided);
  v = good();
  v.settings.seeds = 4;
  EXPECT_EQ(judge(v).outcome, Outcome::kUndecided);
}

TEST(Verdict, SaysInASentenceWhatItIsAndWhatWouldDecide) {
  Validation v = good();
  EXPECT_EQ(judge(v).sentence, "looks the same, within 0.3 % of Cycles in every region");
  v.seconds = 120;
  // Twice the aimed half width of 0.12 % with the work of the first pass: four times the paths, and --focus
  // off.
  v.settings.focus = 1;
  v.regions[0] = region("skin", 1.001, 0.0024);
  EXPECT_EQ(judge(v).sentence,
            "looks the same; too noisy to be sure of skin within 0.3 %: `--spp 512`, about 8 minutes");
  // What --focus gives by itself is not asked for again: a hundred times the work behind it was not enough.
  v.settings.focus = 100;
  v.regions[0].work = {80, 1280, 1280};
  EXPECT_EQ(judge(v).sentence,
            "looks the same; too noisy to be sure of skin within 0.3 %: `--spp 512`, about 8 minutes");
  v.settings.focus = 1;
  v.settings.spp = kMaxCyclesSpp;
  v.regions[0].work = {8, kMaxCyclesSpp, kMaxCyclesSpp};
  EXPECT_NE(judge(v).sentence.find("`--seeds 32`, about 8 minutes"), std::string::npos) << judge(v).sentence;
  v = good();
  v.seconds = 10;
  v.settings.seeds = 4;
  EXPECT_EQ(judge(v).sentence,
            "looks the same; 4 images a side are too few to be sure: `--seeds 8`, about 20 seconds");
  v = good();
  v.regions[0] = region("skin", 1.012, 0.002);
  EXPECT_EQ(judge(v).sentence, "differs from Cycles: skin is 1.20 % brighter");
}

TEST(Verdict, LeavesOutRegionsOfAFewPixels) {
  Validation v = good();
  v.regions[0] = region("hair", 1.1, 0.01, 10);
  EXPECT_EQ(judge(v).outcome, Outcome::kPass);
}

TEST(Verdict, NamesRejectedBinsSettingsAndNans) {
  Validation v = good();
  v.inside_bins.bins = 100;
  v.inside_bins.accepted = 98;
  v.inside_bins.accepted_share = 0.98;
  v.blender_settings.push_back({"scene.cycles.blur_glossy", "0.0", "1.0", false});
  v.nonfinite = 3;
  const Verdict verdict = judge(v);
  EXPECT_EQ(verdict.outcome, Outcome::kDifference);
  std::string all;
  for (const std::string& reason : verdict.reasons) all += reason;
  for (const char* part : {"98.00 %", "scene.cycles.blur_glossy", "3 contributions"})
    EXPECT_NE(all.find(part), std::string::npos) << part;
}

TEST(Verdict, OneRejectedBinIsNoDifferenceYet) {
  Validation v = good();
  v.inside_bins.bins = 155;
  v.inside_bins.accepted = 154;
  v.inside_bins.accepted_share = 154 / 155.0;
  EXPECT_EQ(judge(v).outcome, Outcome::kUndecided);
  EXPECT_EQ(judge(v).sentence, "looks the same but for one place, which may be chance: try another `--seed`");
  v.inside_bins.accepted = 153;
  v.inside_bins.accepted_share = 153 / 155.0;
  EXPECT_EQ(judge(v).outcome, Outcome::kDifference);
  // Of many bins one is below the share that is allowed.
  v.inside_bins.bins = 1000;
  v.inside_bins.accepted = 998;
  v.inside_bins.accepted_share = 0.998;
  EXPECT_EQ(judge(v).outcome, Outcome::kPass);
}

TEST(Report, IsOneFolderThatNeedsNothingElse) {
  const TemporaryFolder folder;
  Validation v = good();
  v.verdict = judge(v);
  write_validation(folder.path(), v);
  const std::string html = read_file(folder / "index.html");
  EXPECT_EQ(html.find("://"), std::string::npos);
  EXPECT_NE(html.find("&lt;person &amp; co&gt;"), std::string::npos);
  const std::regex image("<img src=\"([^\"]+)\" alt=\"[^\"]+\">");
  size_t images = 0;
  for (std::sregex_iterator it(html.begin(), html.end(), image), end; it != end; ++it, ++images)
    EXPECT_EQ(read_image(folder / (*it)[1]).width_px, 12) << (*it)[1];
  EXPECT_EQ(images, 4u);
  const auto json = nlohmann::json::parse(read_file(folder / "validate.json"));
  EXPECT_EQ(json["verdict"], "pass");
  EXPECT_DOUBLE_EQ(json["speed_at_equal_error"]["wall"], 6);
  EXPECT_EQ(json["regions"][0]["name"], "skin");
  const auto parts = read_exr(folder / "ours.exr");
  EXPECT_EQ(find_part(parts, "variance_of_one_seed", "").image.pixel(5, 5)[0], 0.01f);
}

TEST(Pictures, ColoursAndScales) {
  EXPECT_GT(diverging_colour(1).x, diverging_colour(1).z);
  EXPECT_LT(diverging_colour(-5).x, diverging_colour(-1).z);
  EXPECT_NEAR(diverging_colour(0).x, diverging_colour(0).z, 1e-6);
  Image values(10, 10, 1);
  for (float& value : values.values) value = -0.03f;
  EXPECT_FLOAT_EQ(round_limit(values, std::vector<uint8_t>(100, 1), 0.01f), 0.05f);
  EXPECT_FLOAT_EQ(round_limit(values, std::vector<uint8_t>(100, 0), 0.01f), 0.01f);
}

}  // namespace
}  // namespace ohb
