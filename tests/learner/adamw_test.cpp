// The optimiser against libtorch's, and its one pass on the CPU against libtorch's operators.
#include "learner/adamw.h"

#include <gtest/gtest.h>

namespace ohb {
using namespace learner;
namespace {

TEST(AdamW, EqualsLibtorchs) {
  torch::manual_seed(1);
  torch::nn::Linear mine(6, 4), theirs(6, 4);
  {
    torch::NoGradGuard guard;
    theirs->weight.copy_(mine->weight);
    theirs->bias.copy_(mine->bias);
  }
  AdamW optimiser(*mine, {0.0});
  torch::optim::AdamW reference(theirs->parameters(), torch::optim::AdamWOptions(1e-2).weight_decay(0));
  for (int64_t step = 1; step <= 20; ++step) {
    const torch::Tensor x = torch::rand({3, 6});
    optimiser.clear_gradients();
    mine(x).pow(2).sum().backward();
    optimiser.update(1e-2, step);
    reference.zero_grad();
    theirs(x).pow(2).sum().backward();
    reference.step();
  }
  EXPECT_TRUE(torch::allclose(mine->weight, theirs->weight, 1e-5, 1e-6));
  EXPECT_TRUE(torch::allclose(mine->bias, theirs->bias, 1e-5, 1e-6));
}

/// Some steps of a layer with clipping, decay and averages, in that type: float takes the kernel, double the
/// operators.
std::vector<torch::Tensor> after_steps(torch::ScalarType type, double average_decay) {
  torch::manual_seed(2);
  torch::nn::Conv2d layer(torch::nn::Conv2dOptions(5, 7, 3));  // 315 weights: no whole vectors
  layer->to(type);
  AdamW::Options options;
  options.weight_decay = 0.3;
  options.average_decay = average_decay;
  AdamW optimiser(*layer, options);
  for (int64_t step = 1; step <= 30; ++step) {
    torch::manual_seed(static_cast<uint64_t>(step));
    const torch::Tensor x = torch::rand({2, 5, 6, 6}).contiguous(torch::MemoryFormat::ChannelsLast);
    optimiser.clear_gradients();
    layer(x.to(type)).pow(2).sum().backward();
    optimiser.clip_gradients(1);
    optimiser.update(1e-2, step);
  }
  std::vector<torch::Tensor> all;
  for (const AdamW::State& s : optimiser.states())
    for (const torch::Tensor& tensor : {s.parameter, s.first, s.second, s.average})
      if (tensor.defined()) all.push_back(tensor.detach().to(torch::kDouble));
  return all;
}

TEST(AdamW, OnePassEqualsTheOperators) {
  for (const double average_decay : {0.0, 0.9995}) {
    const auto floats = after_steps(torch::kFloat, average_decay);
    const auto doubles = after_steps(torch::kDouble, average_decay);
    ASSERT_EQ(floats.size(), average_decay > 0 ? 8u : 6u);
    for (size_t i = 0; i < floats.size(); ++i)
      EXPECT_TRUE(torch::allclose(floats[i], doubles[i], 1e-4, 1e-5)) << i << " of " << average_decay;
  }
}

}  // namespace
}  // namespace ohb
