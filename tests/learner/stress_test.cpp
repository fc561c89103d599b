// Pictures from harmless to impossible, and what is reported of them.
#include "learner/stress.h"

#include <gtest/gtest.h>

#include "learner/stress_cases.h"
#include "learner/task.h"
#include "learner/train.h"
#include "test_samples.h"
#include "tests/support/test_files.h"

namespace ohb {
using namespace learner;
namespace {

using torch::Tensor;

constexpr int kSize_px = 32;

StressSubject subject() {
  StressSubject s;
  s.example = example_of(ball_sample(kSize_px, "ada", 0), "view_000.exr", 0, kSize_px);
  s.sky = s.example.truth.diffuse.clone();
  s.sun = s.sky * s.example.truth.normal.select(1, 0).clamp_min(0).unsqueeze(1);
  return s;
}

const StressKind& kind_of(const std::vector<StressKind>& kinds, const std::string& name) {
  return *std::find_if(kinds.begin(), kinds.end(), [&](const StressKind& k) { return k.name == name; });
}

Tensor colours_of(const StressPicture& picture) {
  return (picture.input.slice(1, 0, 3) + 1) / 2;
}

TEST(StressKinds, ShareOneHarmlessPicture) {
  const auto kinds = stress_kinds(kSize_px);
  const StressSubject s = subject();
  const Tensor harmless = kinds.front().picture(s, kinds.front().harmless).input;
  for (const StressKind& kind : kinds) {
    EXPECT_TRUE(std::count(kind.levels.begin(), kind.levels.end(), kind.harmless)) << kind.name;
    EXPECT_TRUE(kind.picture(s, kind.harmless).input.equal(harmless)) << kind.name;
    for (const double level : kind.levels) {
      const StressPicture picture = kind.picture(s, level);
      EXPECT_EQ(picture.input.sizes(), harmless.sizes()) << kind.name << level;
      EXPECT_TRUE(torch::isfinite(picture.input).all().item<bool>()) << kind.name << level;
      EXPECT_GT((picture.mask > 0.5).sum().item<int>(), 8) << kind.name << level;
      EXPECT_EQ(picture.network_px % kResolutionStep, 0) << kind.name << level;
      if (level != kind.harmless && kind.name != "size") {
        EXPECT_FALSE(picture.input.equal(harmless)) << kind.name << level;
      }
    }
  }
}

TEST(StressKinds, DoWhatTheySay) {
  const auto kinds = stress_kinds(kSize_px);
  const StressSubject s = subject();
  const Tensor inside = (s.example.mask > 0.5).expand({1, 3, kSize_px, kSize_px});
  const auto& exposure = kind_of(kinds, "exposure");
  const auto clipped = [&](double stops) {
    return (colours_of(exposure.picture(s, stops)).masked_select(inside) >= 0.999).to(torch::kDouble).mean();
  };
  EXPECT_LT(clipped(0).item<double>(), 0.06) << "the 95th percentile of the largest channel is at 0.8";
  EXPECT_GT(clipped(4).item<double>(), 0.3);
  // Two stops of light between red and blue are two stops in the linear picture, where nothing is clipped.
  const auto& colour = kind_of(kinds, "colour");
  const Tensor white = linear_of(colours_of(colour.picture(s, 0))),
               warm = linear_of(colours_of(colour.picture(s, 1)));
  const Tensor ratio =
      (warm / white.clamp_min(1e-6)).select(1, 0) / (warm / white.clamp_min(1e-6)).select(1, 2);
  EXPECT_NEAR(ratio.masked_select(inside.select(1, 0)).median().item<double>(), 4, 0.2);
  const auto area = [&](double pixels) {
    return ((kind_of(kinds, "mask").picture(s, pixels).input.select(1, 3) + 1) / 2).sum().item<double>();
  };
  EXPECT_GT(area(4), area(1));
  EXPECT_LT(area(-4), area(-1));
  // Half of the height fills the frame: the mask keeps twice the share that it had of the square it came
  // from.
  const StressPicture half = kind_of(kinds, "crop").picture(s, 0.5);
  EXPECT_GT(half.mask.mean().item<double>(), s.example.mask.mean().item<double>());
  EXPECT_FALSE(half.same_pixels);
}

TEST(Jpeg, LosesMoreAtLowerQuality) {
  const Tensor picture = torch::rand({1, 3, 32, 32}, at::detail::createCPUGenerator(2));
  const auto error = [&](int quality) {
    return (as_jpeg(picture, quality) - picture).abs().mean().item<double>();
  };
  EXPECT_LT(error(100), 0.01) << "steps of one code";
  EXPECT_GT(error(50), 2 * error(95));
  EXPECT_GT(error(5), error(50));
  // A flat block keeps its level to the rounding of the mean coefficient: 16 / 8 codes at quality 50.
  const Tensor flat = torch::full({1, 3, 8, 8}, 0.4);
  EXPECT_LT((as_jpeg(flat, 50) - flat).abs().max().item<double>(), 1.6 / 255 + 1e-6);
}

TEST(Stress, ReportsEveryLevel) {
  TemporaryFolder folder;
  write_ball_dataset(folder / "data", 2, 2, kSize_px);
  StressOptions o;
  for (const Task task : {Task::kGeometry, Task::kAlbedo, Task::kRss}) {
    torch::manual_seed(3);
    const auto file = folder / (std::string(name_of(task)) + ".safetensors");
    save_weights(
        file, {{"format", 1}, {"task", name_of(task)}, {"width", 0.125}, {"size_px", kSize_px}, {"step", 0}},
        make_network(task, 0.125));
    o.weights.push_back(file);
  }
  o.data = folder / "data";
  o.spp = 2;
  o.quiet = true;
  const StressReport report = run_stress(o);
  EXPECT_EQ(report.people, 2u);
  EXPECT_EQ(report.series.size(), stress_kinds(kSize_px).size());
  for (const StressSeries& series : report.series)
    for (const StressLevel& level : series.levels) {
      EXPECT_EQ(level.pictures, 2u);
      EXPECT_TRUE(std::isfinite(level.psnr[1].masked)) << series.name;
      EXPECT_EQ(std::isfinite(level.change), series.name != "crop" || level.level == 1) << series.name;
      if (level.level == series.harmless && series.name != "size") {
        EXPECT_NEAR(level.change, 0, 1e-6) << series.name;
      }
      EXPECT_LE(std::abs(level.baked_in), 1 + 1e-9) << series.name;
    }
  EXPECT_NE(stress_table(report).find("| contrast"), std::string::npos);
  EXPECT_EQ(stress_json(report)["kinds"].size(), report.series.size());
  draw_stress(report, folder.path());
  EXPECT_TRUE(std::filesystem::exists(folder / "chart.svg"));
}

TEST(Stress, BrokenIsFarBelowTheHarmless) {
  StressSeries series{"noise", "deviation", 0, {}};
  for (const auto& [level, dB] : {std::pair{0.0, 20.0}, {0.1, 18.0}, {0.2, 16.5}, {0.3, 12.0}}) {
    StressLevel l;
    l.level = level;
    l.psnr[1].masked = dB;
    series.levels.push_back(l);
  }
  EXPECT_EQ(series.broken(), (std::vector<double>{0.2, 0.3}));
}

}  // namespace
}  // namespace ohb
