// Measures beside PSNR, against what is known of simple pictures, and groups of people by name.
#include "learner/measures.h"

#include <gtest/gtest.h>

#include <cmath>

#include "learner/evaluate.h"
#include "test_maps.h"

namespace ohb {
using namespace learner;
namespace {

using torch::Tensor;

TEST(Measures, OfTheTruthAreTheBest) {
  const MaterialMaps truth = random_maps(1, 16, 16, torch::kFloat, 1);
  const Measures m = measures_of(truth, truth, torch::ones({1, 1, 16, 16}));
  EXPECT_NEAR(m[kNormalMean_deg], 0, 1e-4);
  EXPECT_EQ(m[kAlbedoScaled_dB], 100);
  EXPECT_NEAR(m[kAlbedoSsim], 1, 1e-9);
  EXPECT_EQ(m[kClassIou], 1);
}

TEST(Measures, AnglesOfTurnedNormals) {
  MaterialMaps truth = random_maps(1, 8, 8, torch::kFloat, 1);
  truth.normal = torch::tensor({0.0f, 0.0f, 1.0f}).view({1, 3, 1, 1}).expand({1, 3, 8, 8}).contiguous();
  MaterialMaps turned = truth;
  turned.normal = truth.normal.clone();
  // Three quarters of the pixels by 30 degrees, the last two rows by 90, which only the mean sees.
  turned.normal.select(1, 0).fill_(std::sin(M_PI / 6));
  turned.normal.select(1, 2).fill_(std::cos(M_PI / 6));
  turned.normal.slice(2, 6, 8).select(1, 0).fill_(1);
  turned.normal.slice(2, 6, 8).select(1, 2).fill_(0);
  Tensor mask = torch::ones({1, 1, 8, 8});
  Measures m = measures_of(turned, truth, mask);
  EXPECT_NEAR(m[kNormalMedian_deg], 30, 1e-3);
  EXPECT_NEAR(m[kNormalMean_deg], 45, 1e-3);
  mask.slice(2, 6, 8).fill_(0);
  EXPECT_NEAR(measures_of(turned, truth, mask)[kNormalMean_deg], 30, 1e-3);
}

TEST(Measures, ScaleOfTheAlbedoDoesNotCount) {
  MaterialMaps truth = random_maps(1, 16, 16, torch::kFloat, 2);
  truth.diffuse = truth.diffuse * 0.5;
  MaterialMaps brighter = truth;
  brighter.diffuse = truth.diffuse * 1.7;
  const Tensor mask = torch::ones({1, 1, 16, 16});
  EXPECT_GT(measures_of(brighter, truth, mask)[kAlbedoScaled_dB], 80);
  brighter.diffuse.select(1, 0).mul_(0.5);
  EXPECT_LT(measures_of(brighter, truth, mask)[kAlbedoScaled_dB], 30) << "but its colour does";
}

TEST(Measures, SsimOfFlatPicturesIsItsFirstFactor) {
  const Tensor a = torch::full({1, 3, 24, 24}, 0.5), b = torch::full({1, 3, 24, 24}, 0.3);
  Tensor mask = torch::ones({1, 1, 24, 24});
  const double expected = (2 * 0.5 * 0.3 + 1e-4) / (0.5 * 0.5 + 0.3 * 0.3 + 1e-4);
  EXPECT_NEAR(ssim(a, b, mask), expected, 1e-6);
  // What is beyond the mask does not count, however different.
  Tensor other = b.clone();
  other.slice(2, 0, 12).fill_(0.9);
  mask.slice(2, 0, 12).fill_(0);
  EXPECT_NEAR(ssim(a, other, mask), expected, 1e-6);
}

TEST(Measures, SsimOfAnInvertedPatternIsNegative) {
  const Tensor x = torch::rand({1, 1, 32, 32}, at::detail::createCPUGenerator(1)) * 0.8 + 0.1;
  const Tensor mask = torch::ones({1, 1, 32, 32});
  EXPECT_LT(ssim(x, 1 - x, mask), -0.7);
  EXPECT_GT(ssim(x, x + 0.01, mask), 0.99);
}

TEST(Measures, ClassesAreTheNearestOfTheTable) {
  MaterialMaps truth = random_maps(1, 4, 4, torch::kFloat, 1);
  const auto fill = [](MaterialMaps& maps, int64_t row, double roughness, double specular, double sss) {
    maps.roughness.select(2, row).fill_(roughness);
    maps.specular.select(2, row).fill_(specular);
    maps.sss.select(2, row).fill_(sss);
  };
  fill(truth, 0, 0.4, 0.184, 0.08);   // skin
  fill(truth, 1, 0.5, 0.239, 0);      // hair
  fill(truth, 2, 0.85, 0.263, 0);     // fabric
  fill(truth, 3, 0.25, 0.224, 0.01);  // leather, nearly
  const Tensor classes = nearest_classes(truth);
  for (int64_t row = 0; row < 4; ++row) EXPECT_EQ(classes[0][row][0].item<int64_t>(), row);
  MaterialMaps estimate = random_maps(1, 4, 4, torch::kFloat, 1);
  for (const int64_t row : {0, 1}) fill(estimate, row, 0.4, 0.184, 0.08);
  for (const int64_t row : {2, 3}) fill(estimate, row, 0.85, 0.263, 0);
  // Skin and fabric are each half of what was taken for them, hair and leather are lost.
  EXPECT_NEAR(measures_of(estimate, truth, torch::ones({1, 1, 4, 4}))[kClassIou], 0.25, 1e-9);
}

TEST(Bootstrap, IntervalIsThatOfTheMean) {
  std::vector<double> values;
  for (int i = 0; i < 100; ++i) values.push_back(i % 2 == 0 ? -1 : 1);
  const Interval interval = bootstrap_of_mean(values);
  // Deviation 1, so the mean of 100 deviates by 0.1: 90 % within 1.645 times that.
  EXPECT_NEAR(interval.low, -0.1645, 0.03);
  EXPECT_NEAR(interval.high, 0.1645, 0.03);
  EXPECT_TRUE(std::isnan(bootstrap_of_mean({1, std::nan("")}).low));
  EXPECT_TRUE(std::isnan(bootstrap_of_mean({}).high));
  EXPECT_EQ(bootstrap_of_mean({3}).low, 3);
}

TEST(Groups, AreTheWordsThatSomeShare) {
  const auto groups = groups_of({"p0000_f35_asian", "p0001_m23_asian", "p0006_f47_middle_eastern",
                                 "p0007_m29_middle_eastern", "p0008_f29_white"});
  std::vector<std::string> names;
  for (const auto& [name, people] : groups) names.push_back(name);
  EXPECT_EQ(names, (std::vector<std::string>{"asian", "f", "m", "middle eastern"})) << "p: all, white: one";
  EXPECT_EQ(groups.at("f").size(), 3u);
  EXPECT_TRUE(groups_of({"ada", "bob"}).empty());
}

}  // namespace
}  // namespace ohb
