// Networks side by side.
#include "learner/network_chart.h"

#include <gtest/gtest.h>

#include <fstream>

#include "test_samples.h"
#include "test_weights.h"
#include "tests/support/test_files.h"

namespace ohb {
using namespace learner;
namespace fs = std::filesystem;
namespace {

/// Three priors in one folder of their own, and a joint network, 16 px.
class NetworkCharts : public testing::Test {
 protected:
  void SetUp() override {
    write_ball_dataset(folder / "data", 3, 1, 16);
    fs::create_directory(folder / "priors");
    for (const fs::path& file : weights_in(folder, false))
      fs::rename(file, folder / "priors" / file.filename());
    joint = weights_of({Task::kJoint}, folder)[0];
    options.sets = {folder / "priors", joint};
    options.data = folder / "data";
    options.quiet = true;
  }

  TemporaryFolder folder;
  fs::path joint;
  NetworkChartOptions options;
};

TEST_F(NetworkCharts, SaysWhatEvaluateSays) {
  const NetworkChart chart = chart_networks(options);
  ASSERT_EQ(chart.sets.size(), 2u);
  for (size_t i = 0; i < 2; ++i) {
    EvaluateOptions o;
    o.weights = weights_of_set(options.sets[i]);
    o.data = options.data;
    o.relit.views_a_person = 0;
    o.quiet = true;
    const EvaluationReport report = evaluate(o);
    EXPECT_EQ(report.people.size(), chart.people);
    for (size_t c = 0; c < kColumns.size(); ++c)
      EXPECT_EQ(chart.sets[i].mean.psnr[c].masked, report.rows[0].mean.psnr[c].masked);
    double sum_dB = 0;
    for (const auto& [name, person] : report.rows[0].people) sum_dB += maps_mean(person.psnr, &Psnr::masked);
    const double mean_dB = sum_dB / static_cast<double>(chart.people);
    EXPECT_LE(chart.sets[i].maps_mean_dB.low, mean_dB + 1e-9);
    EXPECT_GE(chart.sets[i].maps_mean_dB.high, mean_dB - 1e-9);
    EXPECT_GT(chart.sets[i].seconds, 0);
  }
  // A fifth of the multiplies of the paper's four networks is less than half of the three priors'.
  EXPECT_LT(chart.sets[1].billion_multiplies, 0.5 * chart.sets[0].billion_multiplies);
  EXPECT_TRUE(chart.sets[0].is_on_front || chart.sets[1].is_on_front);
}

// A person whom one of them knows would be easy for it alone.
TEST_F(NetworkCharts, LeavesOutWhomOneOfThemKnows) {
  LoadedNetwork loaded = load_network(joint);
  loaded.header["trained_on"] = {"person1"};
  loaded.header["held_out"] = nlohmann::json::array();
  save_weights(joint, loaded.header, loaded.network);
  const NetworkChart chart = chart_networks(options);
  EXPECT_EQ(chart.people, 1u);  // the priors were trained on person0
  EXPECT_TRUE(chart.sets[0].known.empty() && chart.sets[1].known.empty());
  options.people = {"person1"};
  const NetworkChart named = chart_networks(options);
  EXPECT_EQ(named.sets[1].known, std::vector<std::string>{"person1"});
  EXPECT_NE(network_chart_table(named).find("TRAINED ON, not held out: person1 (by " + joint.string()),
            std::string::npos);
}

TEST_F(NetworkCharts, RefusesSetsThatAreNone) {
  fs::create_directory(folder / "empty");
  options.sets = {folder / "empty"};
  expect_message(input_error_of([&] { chart_networks(options); }), {"empty", "neither weights", "nor runs"});
  options.sets = {joint, folder / "priors" / "albedo.safetensors"};
  expect_message(input_error_of([&] { chart_networks(options); }), {"geometry"});
  options.sets = {folder / "nothing"};
  expect_message(input_error_of([&] { chart_networks(options); }), {"nothing"});
}

TEST(NetworkChart, TakesTheFastestThatIsAsGood) {
  NetworkChart chart;
  const auto add = [&](const char* name, double seconds, double dB) {
    NetworkMarks set;
    set.name = name;
    set.seconds = seconds;
    set.mean.psnr.fill({dB, dB});
    chart.sets.push_back(set);
  };
  add("slow", 1, 28.30);
  add("small", 0.1, 27.0);
  add("as good", 0.3, 28.15);
  add("worse", 0.2, 28.05);
  EXPECT_EQ(chart.to_take().name, "as good");
  EXPECT_EQ(network_chart_json(chart)["take"], "as good");
}

TEST_F(NetworkCharts, DrawsAPointASet) {
  draw_network_chart(chart_networks(options), folder.path());
  std::ifstream drawn(folder / "chart.svg");
  const std::string svg((std::istreambuf_iterator<char>(drawn)), std::istreambuf_iterator<char>());
  EXPECT_NE(svg.find("joint.safetensors"), std::string::npos);
  EXPECT_NE(svg.find("priors"), std::string::npos);
}

}  // namespace
}  // namespace ohb
