// Convolutions whose weights' gradient is our own against libtorch's in double precision.
#include "learner/conv.h"

#include <gtest/gtest.h>

#include <array>
#include <ostream>
#include <set>
#include <thread>

#include "learner/conv_kernel.h"

namespace ohb {
using namespace learner;
namespace {

using torch::Tensor;
namespace kernel = conv_kernel;

struct Case {
  int64_t images, in, out, height, width, stride;
};

std::ostream& operator<<(std::ostream& stream, const Case& c) {
  return stream << c.images << "x" << c.in << "x" << c.height << "x" << c.width << " to " << c.out
                << ", stride " << c.stride;
}

torch::nn::Conv2d layer_of(const Case& c, bool has_bias) {
  return torch::nn::Conv2d(
      torch::nn::Conv2dOptions(c.in, c.out, 3).stride(c.stride).padding(1).bias(has_bias));
}

double largest_relative(const Tensor& a, const Tensor& b) {
  return ((a.to(torch::kDouble) - b).abs().max() / b.abs().max()).item<double>();
}

class Conv : public testing::TestWithParam<Case> {};

TEST_P(Conv, HasTheGradientsOfDoublePrecision) {
  const Case c = GetParam();
  torch::manual_seed(5);
  for (const bool has_bias : {false, true}) {
    torch::nn::Conv2d layer = layer_of(c, has_bias), plain = layer_of(c, has_bias);
    plain->to(torch::kDouble);
    {
      const torch::NoGradGuard no_gradients;
      plain->weight.copy_(layer->weight);
      if (has_bias) plain->bias.copy_(layer->bias);
    }
    const Tensor x = torch::randn({c.images, c.in, c.height, c.width}).requires_grad_();
    const Tensor x_double = x.detach().to(torch::kDouble).requires_grad_();
    const Tensor y = conv3x3(x, layer), y_double = plain(x_double);
    const Tensor weight = torch::randn_like(y_double);
    (y * weight.to(torch::kFloat)).sum().backward();
    (y_double * weight).sum().backward();
    EXPECT_LT(largest_relative(y, y_double), 1e-5);
    EXPECT_LT(largest_relative(x.grad(), x_double.grad()), 1e-5);
    EXPECT_LT(largest_relative(layer->weight.grad(), plain->weight.grad()), 1e-5);
    if (has_bias) {
      EXPECT_LT(largest_relative(layer->bias.grad(), plain->bias.grad()), 1e-5);
    }
  }
}

/// Work in the other order, on one thread.
void backwards(int64_t count, void (*body)(int64_t, void*), void* context) {
  for (int64_t i = count; i-- > 0;) body(i, context);
}

// Also where the processor has AVX-512, on which conv3x3 leaves it to libtorch; and the same bits in any
// order.
TEST_P(Conv, KernelsSumWhatDoublePrecisionSums) {
  if (!kernel::is_compiled()) GTEST_SKIP() << "this build is for processors without AVX2";
  const Case c = GetParam();
  torch::manual_seed(6);
  const kernel::Shape shape = {c.images, c.height, c.width, c.in, c.out, c.stride};
  const auto last = torch::MemoryFormat::ChannelsLast;
  const Tensor x = torch::randn({c.images, c.in, c.height, c.width}).contiguous(last);
  const Tensor y_gradient =
      torch::randn({c.images, c.out, shape.height_out(), shape.width_out()}).contiguous(last);
  const Tensor weight = torch::randn({c.out, c.in, 3, 3}), bias = torch::randn({c.out});
  const Tensor weight_double = weight.to(torch::kDouble).requires_grad_();
  const Tensor y_double =
      torch::conv2d(x.to(torch::kDouble), weight_double, bias.to(torch::kDouble), c.stride, 1);
  (y_double * y_gradient).sum().backward();
  std::vector<Tensor> found;
  for (const ParallelFor parallel_for : {openmp_parallel_for, backwards}) {
    Tensor y = torch::full_like(y_gradient, std::nan("")), gradient = torch::full_like(weight, std::nan(""));
    kernel::forward(shape, x.data_ptr<float>(), weight.data_ptr<float>(), bias.data_ptr<float>(),
                    y.data_ptr<float>(), parallel_for);
    kernel::weight_gradient(shape, x.data_ptr<float>(), y_gradient.data_ptr<float>(),
                            gradient.data_ptr<float>(), parallel_for);
    EXPECT_LT(largest_relative(y, y_double), 1e-5);
    EXPECT_LT(largest_relative(gradient, weight_double.grad()), 1e-5);
    found.insert(found.end(), {y, gradient});
  }
  EXPECT_TRUE(found[0].equal(found[2]));
  EXPECT_TRUE(found[1].equal(found[3]));
}

INSTANTIATE_TEST_SUITE_P(Shapes, Conv,
                         testing::Values(Case{1, 16, 16, 16, 16, 1}, Case{3, 32, 48, 7, 5, 1},
                                         Case{2, 48, 16, 9, 12, 2}, Case{1, 16, 32, 1, 1, 1},
                                         Case{2, 16, 16, 1, 1, 2}, Case{2, 64, 64, 2, 3, 2},
                                         Case{1, 16, 16, 70, 33, 2},   // more runs of rows than images
                                         Case{2, 528, 16, 4, 4, 1}));  // more blocks than units

// Kernels once ran on one thread wherever their caller was compiled without OpenMP.
TEST(ParallelFor, UsesTheThreadsThatLibtorchIsGiven) {
  const int before = torch::get_num_threads();
  for (const int threads : {1, 3}) {
    torch::set_num_threads(threads);
    std::array<std::thread::id, 64> of_pass;
    for_each(64, openmp_parallel_for, [&](int64_t i) { of_pass[i] = std::this_thread::get_id(); });
    EXPECT_EQ(std::set<std::thread::id>(of_pass.begin(), of_pass.end()).size(), static_cast<size_t>(threads));
  }
  torch::set_num_threads(before);
}

// What the kernel does not take goes to libtorch: other channels, doubles, pictures plane by plane.
TEST(Conv3x3, TakesAnyPicture) {
  const torch::nn::Conv2d layer = layer_of({1, 5, 7, 0, 0, 1}, true);
  const Tensor x = torch::randn({2, 5, 8, 6});
  EXPECT_TRUE(torch::allclose(conv3x3(x, layer), layer.ptr()->forward(x)));
  const torch::nn::Conv2d wide = layer_of({1, 16, 16, 0, 0, 2}, true);
  const Tensor planes = torch::randn({2, 16, 8, 6});
  EXPECT_TRUE(torch::allclose(conv3x3(planes, wide), wide.ptr()->forward(planes), 1e-5, 1e-5));
  conv3x3(planes.narrow(2, 1, 4), wide).sum().backward();  // no memory of its own
  EXPECT_TRUE(wide->weight.grad().defined());
}

TEST(Pointwise, HasTheGradientsOfDoublePrecision) {
  torch::manual_seed(8);
  // Channels of y, and of x, that the kernel takes in blocks, and others.
  for (const auto& [in, out] : {std::pair{16, 32}, {14, 16}, {48, 10}, {300, 16}}) {
    const Tensor x = torch::randn({2, in, 5, 9}), weight = torch::randn({out, in, 1, 1}),
                 bias = torch::randn({out});
    const auto with_gradients = [&](torch::ScalarType type) {
      std::vector<Tensor> leaves;
      for (const Tensor& t : {x, weight, bias})
        leaves.push_back(t.to(type).detach().clone().requires_grad_());
      const Tensor y = pointwise(leaves[0], leaves[1], leaves[2]);
      y.square().sum().backward();
      return std::vector<Tensor>{y.detach(), leaves[0].grad(), leaves[1].grad(), leaves[2].grad()};
    };
    const std::vector<Tensor> single = with_gradients(torch::kFloat), twice = with_gradients(torch::kDouble);
    for (size_t i = 0; i < single.size(); ++i)
      EXPECT_LT(largest_relative(single[i], twice[i]), 1e-5) << in << " to " << out << ", " << i;
  }
}

TEST(Pointwise, EqualsTheConvolution) {
  torch::manual_seed(5);
  const Tensor x = torch::randn({2, 20, 9, 7}, torch::kDouble).contiguous(torch::MemoryFormat::ChannelsLast);
  const Tensor weight = torch::randn({12, 20, 1, 1}, torch::kDouble),
               bias = torch::randn({12}, torch::kDouble);
  EXPECT_LT((pointwise(x, weight, bias) - torch::conv2d(x, weight, bias)).abs().max().item<double>(), 1e-12);
  EXPECT_LT((pointwise(x, weight, {}) - torch::conv2d(x, weight)).abs().max().item<double>(), 1e-12);
  EXPECT_TRUE(pointwise(x, weight, bias).is_contiguous(torch::MemoryFormat::ChannelsLast));
}

}  // namespace
}  // namespace ohb
