// What a step's time goes to.
#include "learner/profile.h"

#include <gtest/gtest.h>

#include "learner/norm_silu.h"

namespace ohb {
using namespace learner;
namespace {

using Clock = std::chrono::steady_clock;

const ProfileLine* line_of(const std::vector<ProfileLine>& lines, const std::string& kind) {
  for (const ProfileLine& line : lines)
    if (line.kind == kind) return &line;
  return nullptr;
}

TEST(Profile, CountsConvolutionsAndNormsAndSumsToTheWall) {
  const torch::Tensor x = torch::randn({1, 16, 64, 64}),
                      weight = torch::randn({16, 16, 3, 3}).requires_grad_();
  const torch::Tensor ones = torch::ones({16}), zeros = torch::zeros({16});
  const auto start = Clock::now();
  const StepProfile profile;
  for (int i = 0; i < 5; ++i)
    norm_silu(torch::conv2d(x, weight, {}, {1, 1}, {1, 1}), 4, ones, zeros, 1e-5).sum().backward();
  const std::vector<ProfileLine> lines = profile.lines();
  const double wall_s = std::chrono::duration<double>(Clock::now() - start).count();
  ASSERT_TRUE(line_of(lines, "convolutions"));
  EXPECT_GE(line_of(lines, "convolutions")->calls, 10) << "five forward, five backward";
  ASSERT_TRUE(line_of(lines, "norms"));
  EXPECT_EQ(line_of(lines, "norms")->calls % 10, 0);
  double sum_s = 0;
  for (const ProfileLine& line : lines) {
    EXPECT_GE(line.seconds, -1e-9) << line.kind;
    sum_s += line.seconds;
  }
  // One thread works at a time here, so no operator's time counts twice.
  EXPECT_LE(sum_s, wall_s);
  EXPECT_EQ(lines.back().kind, "everything else");
}

TEST(Profile, OneAtATime) {
  const StepProfile first;
  EXPECT_THROW(StepProfile second, std::logic_error);
}

TEST(Profile, KindsOfOperators) {
  EXPECT_EQ(kind_of_operator("aten::convolution_backward"), "convolutions");
  EXPECT_EQ(kind_of_operator("aten::addmm"), "matrix products");
  EXPECT_EQ(kind_of_operator("aten::upsample_bilinear2d_backward"), "up-sampling");
  EXPECT_EQ(kind_of_operator("rendering loss"), "rendering loss");
  EXPECT_EQ(kind_of_operator("aten::pow"), "other operators");
}

}  // namespace
}  // namespace ohb
