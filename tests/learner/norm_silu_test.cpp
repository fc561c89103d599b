// The fused group norm and SiLU against libtorch's own operators in double precision.
#include "learner/norm_silu.h"

#include <gtest/gtest.h>

#include <ostream>

namespace ohb {
using namespace learner;
namespace {

using torch::Tensor;

struct Case {
  int64_t images, channels, side, groups;
  double level, spread;  // of x
};

std::ostream& operator<<(std::ostream& stream, const Case& c) {
  return stream << c.images << "x" << c.channels << "x" << c.side << ", " << c.groups << " groups, level "
                << c.level << ", spread " << c.spread;
}

/// Value and gradients of sum(w y) for fixed random w.
std::vector<Tensor> with_gradients(const Tensor& x, int64_t groups, const Tensor& gain, const Tensor& offset,
                                   const Tensor& weight) {
  const Tensor a = x.detach().clone().requires_grad_(), g = gain.detach().clone().requires_grad_(),
               o = offset.detach().clone().requires_grad_();
  const Tensor y = norm_silu(a, groups, g, o, 1e-5);
  (y * weight).sum().backward();
  return {y.detach(), a.grad(), g.grad(), o.grad()};
}

double largest_relative(const Tensor& a, const Tensor& b) {
  return ((a.to(torch::kDouble) - b).abs().max() / b.abs().max()).item<double>();
}

class NormSilu : public testing::TestWithParam<Case> {};

TEST_P(NormSilu, EqualsThePlainOperatorsInDouble) {
  const Case c = GetParam();
  torch::manual_seed(7);
  const Tensor x =
      torch::randn({c.images, c.channels, c.side, c.side + 3}, torch::kDouble) * c.spread + c.level;
  const Tensor gain = torch::rand({c.channels}, torch::kDouble) + 0.5,
               offset = torch::randn({c.channels}, torch::kDouble);
  const Tensor weight = torch::randn_like(x);
  const auto plain = with_gradients(x, c.groups, gain, offset, weight);  // doubles take libtorch's operators
  const auto f = [](const Tensor& t) { return t.to(torch::kFloat); };
  const auto fused = with_gradients(f(x), c.groups, f(gain), f(offset), f(weight));
  // x itself, rounded to single precision, moves by 6e-8 of its level: that much over the spread.
  const double limit = 2e-6 + 4e-7 * std::abs(c.level) / c.spread;
  const char* names[] = {"value", "gradient of x", "of the gain", "of the offset"};
  for (int i = 0; i < 4; ++i) EXPECT_LT(largest_relative(fused[i], plain[i]), limit) << names[i];
}

INSTANTIATE_TEST_SUITE_P(Shapes, NormSilu,
                         testing::Values(Case{1, 16, 5, 4, 0, 1}, Case{2, 32, 31, 8, 0.3, 2},
                                         Case{3, 64, 16, 16, -5, 0.5}, Case{1, 512, 4, 16, 0, 1},
                                         Case{1, 16, 40, 4, 1000, 1},  // a level far above the spread
                                         Case{2, 16, 9, 4, 0, 1e-3},   // nearly even: epsilon counts
                                         Case{1, 20, 7, 5, 0, 30}));   // sigmoids that saturate

TEST(NormSiluEdges, AnEvenPictureGivesTheOffsetAndNoNaN) {
  const Tensor x = torch::full({1, 16, 8, 8}, 3.0f).requires_grad_();
  const Tensor gain = torch::ones({16}), offset = torch::full({16}, 0.25f);
  const Tensor y = norm_silu(x, 4, gain, offset, 1e-5);
  y.sum().backward();
  EXPECT_LT((y - 0.25f / (1 + std::exp(-0.25f))).abs().max().item<float>(), 1e-6);
  EXPECT_TRUE(torch::isfinite(x.grad()).all().item<bool>());
}

TEST(NormSiluEdges, NaNStaysNaN) {
  Tensor x = torch::randn({1, 16, 8, 8});
  x[0][3][2][2] = std::nanf("");
  const Tensor y = norm_silu(x, 4, torch::ones({16}), torch::zeros({16}), 1e-5);
  EXPECT_TRUE(torch::isnan(y[0][3]).all().item<bool>());
  EXPECT_FALSE(torch::isnan(y[0][8]).any().item<bool>()) << "another group";
}

TEST(NormSiluEdges, AnyNumberOfThreadsGivesTheSameBits) {
  torch::manual_seed(3);
  const Tensor x = torch::randn({2, 32, 70, 50}), gain = torch::rand({32}), offset = torch::randn({32});
  const Tensor weight = torch::randn_like(x);
  const int before = torch::get_num_threads();
  torch::set_num_threads(1);
  const auto one = with_gradients(x, 8, gain, offset, weight);
  torch::set_num_threads(3);
  const auto three = with_gradients(x, 8, gain, offset, weight);
  torch::set_num_threads(before);
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(torch::equal(one[i], three[i])) << i;
}

}  // namespace
}  // namespace ohb
