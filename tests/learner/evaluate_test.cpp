// Metrics, the table, and the folder of maps that estimate writes.
#include "learner/evaluate.h"

#include <gtest/gtest.h>

#include <fstream>
#include <set>

#include "dataset/model/atomic_file.h"
#include "learner/estimate.h"
#include "learner/safetensors.h"
#include "test_maps.h"
#include "test_samples.h"
#include "test_weights.h"
#include "tests/support/test_files.h"

namespace ohb {
using namespace learner;
using namespace renderer;
namespace {

using torch::Tensor;

TEST(Psnr, IsThatOfKnownErrors) {
  const Tensor truth = torch::full({1, 3, 4, 4}, 0.5), half_off = truth + 0.1;
  Tensor mask = torch::ones({1, 1, 4, 4});
  EXPECT_NEAR(psnr(half_off, truth, mask).masked, 20, 1e-4);
  EXPECT_NEAR(psnr(half_off, truth, mask).full, 20, 1e-4);
  mask.slice(2, 0, 2).fill_(0);  // half of the frame: 3.01 dB more
  EXPECT_NEAR(psnr(half_off, truth, mask).masked, 20, 1e-4);
  EXPECT_NEAR(psnr(half_off, truth, mask).full, 20 + 10 * std::log10(2), 1e-4);
  EXPECT_EQ(psnr(truth, truth, mask).masked, 100);
}

TEST(Scores, OfTheTruthAreTheMostAndOfEightBitsHigh) {
  const MaterialMaps truth = random_maps(1, 32, 32, torch::kFloat, 1);
  const Tensor mask = torch::ones({1, 1, 32, 32});
  for (const Psnr& p : scores_of(truth, truth, mask)) EXPECT_EQ(p.masked, 100);
  const Scores stored = scores_of(eight_bit(truth), truth, mask);
  // Rounding error is uniform in half a code: 10 log10(12 x 255^2) = 58.9 dB.
  for (const size_t column : {1, 2, 3, 4, 5})
    EXPECT_NEAR(stored[column].masked, 58.9, 0.5) << kColumns[column];
}

TEST(Evaluate, FillsTheTableForHeldOutPeople) {
  TemporaryFolder folder;
  write_ball_dataset(folder / "data", 3, 2, 32);
  EvaluateOptions o;
  o.weights = weights_in(folder, true);
  o.data = folder / "data";
  o.relit.views_a_person = 1;
  o.relit.spp = 2;
  o.quiet = true;
  EvaluationReport report = evaluate(o);
  EXPECT_EQ(report.people, std::vector<std::string>{"person1"});
  EXPECT_EQ(report.pictures, 4u) << "two views under two lights";
  EXPECT_EQ(report.size_px, 16);
  std::set<std::string> rows;
  for (const EvaluationRow& row : report.rows) rows.insert(row.name);
  EXPECT_EQ(rows,
            (std::set<std::string>{"finetuned", "priors", "constant", "input as albedo", "8-bit truth"}));
  for (const EvaluationRow& row : report.rows)
    for (size_t c = 0; c < kColumns.size(); ++c)
      EXPECT_EQ(std::isfinite(row.mean.psnr[c].masked), row.name != "input as albedo" || c == 1)
          << row.name << c;
  const std::string table = table_of(report);
  EXPECT_NE(table.find("| priors "), std::string::npos) << table;
  EXPECT_EQ(json_of(report)["rows"].size(), 5u);
  EXPECT_NE(table.find("finetuned, by light"), std::string::npos) << table;
  ASSERT_EQ(report.lights.size(), 2u);
  EXPECT_EQ(report.lights[1].name, "right");
  EXPECT_EQ(report.lights[1].count, 2u);
  for (const EvaluationRow& row : report.rows)
    for (const size_t m : {kAlbedoScaled_dB, kAlbedoSsim})
      EXPECT_TRUE(std::isfinite(row.mean.measures[m])) << row.name << kMeasureNames[m];
  EXPECT_LT(report.rows.back().mean.measures[kNormalMean_deg], 0.5) << "8-bit truth";
  // Pixels of two materials in equal shares are as near to the one as to the other: rounding decides.
  EXPECT_GT(report.rows.back().mean.measures[kClassIou], 0.8);
  ASSERT_TRUE(report.relit);
  EXPECT_EQ(report.relit->pictures, 1u) << "one view under one light";
  std::vector<std::string> relit_rows;
  for (const RelitRow& row : report.relit->rows) {
    relit_rows.push_back(row.name);
    for (const Psnr& score : row.mean) EXPECT_GT(score.masked, 0) << row.name;
  }
  EXPECT_EQ(relit_rows, (std::vector<std::string>{"finetuned", "priors", "constant", "8-bit truth"}));
  EXPECT_NE(table.find("sunset frame |"), std::string::npos) << table;
  EXPECT_GT(json_of(report)["relighting"]["rows"][3]["mean"]["studio"]["masked"], 30);
  o.relit.views_a_person = 0;
  o.people = {"person0", "person2"};
  o.weights = weights_in(folder, false);
  report = evaluate(o);
  EXPECT_EQ(report.rows.size(), 4u) << "no finetuned row";
  EXPECT_FALSE(json_of(report).contains("relighting"));
  EXPECT_EQ(report.rows[0].people.size(), 2u);
  o.people = {"nobody"};
  expect_message(input_error_of([&] { evaluate(o); }), {"nobody"});
  o.people.clear();
}

TEST(Evaluate, TakesNobodyForUnseenWhomOneNetworkKnows) {
  TemporaryFolder folder;
  write_ball_dataset(folder / "data", 3, 1, 16);
  EvaluateOptions o;
  o.weights = weights_in(folder, false);
  o.data = folder / "data";
  o.relit.views_a_person = 0;
  o.quiet = true;
  // The albedo prior was trained on the one whom the geometry prior held out.
  const LoadedNetwork albedo = load_network(folder / "albedo.safetensors");
  nlohmann::json header = albedo.header;
  header["trained_on"] = {"person1", "person2"};
  header["held_out"] = {"person0"};
  save_weights(folder / "albedo.safetensors", header, albedo.network);
  expect_message(input_error_of([&] { evaluate(o); }), {"trained on everybody", "--person"});
  o.people = {"person1"};
  const EvaluationReport report = evaluate(o);
  EXPECT_EQ(report.trained_on.at("person1"), std::vector<std::string>{"albedo"});
  EXPECT_NE(table_of(report).find("TRAINED ON, not held out: person1 (by albedo)"), std::string::npos);
  EXPECT_EQ(json_of(report)["trained_on"]["person1"][0], "albedo");
  // A person whom both left alone.
  o.people.clear();
  header["trained_on"] = {"person0", "person2"};
  header["held_out"] = {"person1"};
  save_weights(folder / "albedo.safetensors", header, albedo.network);
  EXPECT_EQ(evaluate(o).people, std::vector<std::string>{"person1"});
  EXPECT_TRUE(evaluate(o).trained_on.empty());
}

TEST(Evaluate, OnePriorAlone) {
  TemporaryFolder folder;
  write_ball_dataset(folder / "data", 2, 1, 16);
  EvaluateOptions o;
  const auto weights = weights_in(folder, true);
  o.data = folder / "data";
  o.relit.views_a_person = 1;
  o.quiet = true;
  const std::vector<std::set<std::string>> columns = {{"N", "Disp"}, {"D"}, {"R", "S", "SSS"}};
  for (size_t i = 0; i < columns.size(); ++i) {
    o.weights = {weights[i]};
    const EvaluationReport report = evaluate(o);
    EXPECT_FALSE(report.relit);
    const EvaluationRow& row = report.rows[0];
    EXPECT_EQ(row.name, "priors");
    for (size_t c = 0; c < kColumns.size(); ++c)
      EXPECT_EQ(std::isfinite(row.mean.psnr[c].masked), columns[i].count(kColumns[c]) > 0) << kColumns[c];
  }
  o.weights = {weights[0], weights[1], weights[3]};
  expect_message(input_error_of([&] { evaluate(o); }), {"no rss prior"});
  o.weights = {weights[0], weights[0]};
  expect_message(input_error_of([&] { evaluate(o); }), {"second geometry network"});
}

TEST(Estimate, WritesAFolderThatSaysWhatItIs) {
  TemporaryFolder folder;
  Image photo(50, 80, 4);
  for (int y = 10; y < 70; ++y)
    for (int x = 15; x < 35; ++x)
      for (int c = 0; c < 4; ++c) photo.pixel(x, y)[c] = c == 3 ? 1 : 0.5f;
  write_png(folder / "photo.png", photo);
  EstimateOptions o;
  o.photo = folder / "photo.png";
  o.weights = weights_in(folder, true);
  o.output = folder / "maps";
  o.person_height_cm = 180;
  const EstimateReport report = estimate(o);
  EXPECT_TRUE(report.finetuned);
  EXPECT_DOUBLE_EQ(report.crop.side_px, 66);
  const auto json = nlohmann::json::parse(read_file(o.output / "maps.json"));
  EXPECT_EQ(json["format"], "humanmaterial.maps");
  EXPECT_EQ(json["size_px"], (std::vector<int>{64, 64})) << "of the photo's 66";
  const double r_cm = json["maps"]["displacement"]["r_cm"];
  EXPECT_NEAR(r_cm, 0.5 * 66 * 180 / 60, 1e-6) << "60 px are 180 cm";
  EXPECT_NEAR(json["camera"]["distance_cm"].get<double>() * json["camera"]["half_width"].get<double>(), r_cm,
              1e-6);
  for (const auto& [name, map] : json["maps"].items()) {
    ImageFileInfo info;
    const Image image = read_image(o.output / map["file"].get<std::string>(), &info);
    EXPECT_EQ(info.bits, 16) << name;
    EXPECT_EQ(image.width_px, 64) << name;
    EXPECT_EQ(image.channels, name == "normal" || name == "diffuse" ? 3 : 1) << name;
  }
  // The EXR holds the same numbers in their own units.
  const auto parts = read_exr(o.output / "maps.exr");
  const Image& depth = find_part(parts, "displacement", "maps.exr").image;
  const Image png = read_image(o.output / "displacement.png");
  EXPECT_NEAR(depth.pixel(8, 8)[0], (2 * png.pixel(8, 8)[0] - 1) * r_cm, 2 * r_cm / 65535);
  const Image normal = find_part(parts, "normal", "maps.exr").image;
  const float* n = normal.pixel(8, 8);
  EXPECT_NEAR(n[0] * n[0] + n[1] * n[1] + n[2] * n[2], 1, 1e-4);
  estimate(o);  // its own folder may be written again
}

TEST(Estimate, LeavesNothingBehindWhenItRefuses) {
  TemporaryFolder folder;
  write_png(folder / "photo.png", Image(50, 80, 3));
  EstimateOptions o;
  o.photo = folder / "photo.png";
  o.weights = weights_in(folder, false);
  o.output = folder / "maps";
  expect_message(input_error_of([&] { estimate(o); }), {"photo.png", "--mask"});
  EXPECT_FALSE(std::filesystem::exists(o.output));
  Image mask(50, 80, 1);
  for (int i = 20; i < 40; ++i) mask.pixel(20, i)[0] = 1;
  write_png(folder / "mask.png", mask);
  o.mask = folder / "mask.png";
  o.weights = {folder / "geometry.safetensors"};
  expect_message(input_error_of([&] { estimate(o); }), {"no albedo prior"});
  o.weights = {folder / "photo.png"};
  expect_message(input_error_of([&] { estimate(o); }), {"photo.png"});
  o.weights = weights_in(folder, false);
  o.matting.person = 2;
  expect_message(input_error_of([&] { estimate(o); }), {"photo.png", "--person 2", "--mask says"});
  o.matting.person = 1;
  TensorFile overflowing = read_tensors(o.weights[0]);
  for (auto& [name, tensor] : overflowing.tensors) tensor.fill_(65504);
  write_tensors(o.weights[0], overflowing);
  expect_message(input_error_of([&] { estimate(o); }), {"photo.png", "map 'normal'", "NaN"});
  EXPECT_FALSE(std::filesystem::exists(o.output));
  o.weights = weights_in(folder, false);
  std::filesystem::create_directories(o.output);
  std::ofstream(o.output / "precious.txt") << "mine";
  expect_message(input_error_of([&] { estimate(o); }), {"not written by this program"});
  EXPECT_TRUE(std::filesystem::exists(o.output / "precious.txt"));
}

}  // namespace
}  // namespace ohb
