// Shapes, sizes and costs of the networks.
#include "learner/networks.h"

#include <gtest/gtest.h>

#include "learner/counts.h"

namespace ohb {
using namespace learner;
namespace {

using torch::Tensor;

TEST(Counts, EqualHandCountsOfSmallLayers) {
  torch::nn::Conv2d conv(torch::nn::Conv2dOptions(3, 5, 3).stride(2).padding(1));
  EXPECT_EQ(parameter_count(*conv), 3 * 5 * 9 + 5);
  EXPECT_EQ(count_multiplies([&] { conv(torch::zeros({2, 3, 8, 8})); }), 2 * 5 * 4 * 4 * 3 * 9);
  torch::nn::Linear linear(7, 11);
  EXPECT_EQ(parameter_count(*linear), 7 * 11 + 11);
  EXPECT_EQ(count_multiplies([&] { linear(torch::zeros({2, 6, 7})); }), 2 * 6 * 7 * 11);
  EXPECT_EQ(count_multiplies([&] {
              torch::bmm(torch::zeros({2, 3, 4}), torch::zeros({2, 4, 5}));
            }),
            2 * 3 * 4 * 5);
  ConvBlock block(4, 16, ConvBlockImpl::Scale::kUp);
  EXPECT_EQ(parameter_count(*block), 4 * 16 + 16 * 16 * 9 + 2 * 16);
  EXPECT_EQ(count_multiplies([&] {
              block(torch::zeros({1, 4, 8, 8}));
            }),
            8 * 8 * 4 * 16 + 16 * 16 * 16 * 16 * 9);
}

TEST(Counts, OfAnySizeFollowFromTwoSmallRuns) {
  PriorNet net(3, 0.25);
  const auto run = [&](int64_t size) { net(torch::zeros({1, 4, size, size})); };
  EXPECT_EQ(multiplies_at(run, 128), count_multiplies([&] { run(128); }));
}

// The paper names no sizes: its figure and training times were read as 15.9 M parameters and 179 G multiplies
// of a prior at 512 x 512, and 36.5 M and 586 G of the finetuning model. Ours has 16.44 M, 173.9 G, 36.24 M
// and 563.9 G (exact counts, no noise): 3.4, 2.8, 0.7 and 3.8 % apart, and no further.
constexpr double kReadingError = 0.04;

TEST(PriorNet, HasThePapersSize) {
  PriorNet net(4, 1.0);
  const int64_t multiplies = multiplies_at([&](int64_t size) { net(torch::zeros({1, 4, size, size})); }, 512);
  std::printf("prior: %.2f M parameters, %.1f G multiplies at 512\n", parameter_count(*net) / 1e6,
              multiplies / 1e9);
  EXPECT_NEAR(static_cast<double>(parameter_count(*net)), 15.9e6, kReadingError * 15.9e6);
  EXPECT_NEAR(static_cast<double>(multiplies), 179e9, kReadingError * 179e9);
}

TEST(FinetuneNet, HasThePapersSize) {
  FinetuneNet net(1.0);
  const auto run = [&](int64_t size) {
    net(torch::zeros({1, 4, size, size}), torch::zeros({1, 10, size, size}));
  };
  const int64_t multiplies = multiplies_at(run, 512);
  std::printf("finetune: %.2f M parameters, %.1f G multiplies at 512\n", parameter_count(*net) / 1e6,
              multiplies / 1e9);
  EXPECT_NEAR(static_cast<double>(parameter_count(*net)), 36.5e6, kReadingError * 36.5e6);
  EXPECT_NEAR(static_cast<double>(multiplies), 586e9, kReadingError * 586e9);
}

// It exists to be cheaper: a fifth of the multiplies of the paper's networks together, at any width.
TEST(JointNet, TakesAFifthOfThePapersMultiplies) {
  for (const double width : {0.25, 1.0}) {
    PriorNet prior(4, width);
    FinetuneNet finetune(width);
    JointNet joint(10, width), refining(10, width, true);
    const auto input = [](int64_t size) { return torch::zeros({1, 4, size, size}); };
    const int64_t papers = 3 * multiplies_at([&](int64_t size) { prior(input(size)); }, 128) +
                           multiplies_at(
                               [&](int64_t size) {
                                 finetune(input(size), torch::zeros({1, 10, size, size}));
                               },
                               128);
    const int64_t ours = multiplies_at([&](int64_t size) { joint(input(size)); }, 128);
    std::printf("width %g: joint %.2f G of %.2f G\n", width, ours / 1e9, papers / 1e9);
    EXPECT_LE(5 * ours, papers) << width;
    const int64_t with_maps = multiplies_at(
        [&](int64_t size) {
          refining(input(size), torch::zeros({1, 10, size, size}));
        },
        128);
    EXPECT_LE(with_maps, 1.1 * ours) << width;
  }
}

TEST(Networks, TakeAnyMultipleOfSixteenAndAnyWidth) {
  torch::NoGradGuard no_gradients;
  for (const double width : {0.125, 0.25, 0.5})
    for (const auto& [height, breadth] : {std::pair{16, 16}, {48, 32}}) {
      PriorNet prior(4, width);
      const Tensor maps = prior(torch::rand({2, 4, height, breadth}) * 2 - 1);
      EXPECT_EQ(maps.sizes(), (std::vector<int64_t>{2, 4, height, breadth}));
      EXPECT_GT(maps.min().item<float>(), 0);
      EXPECT_LT(maps.max().item<float>(), 1);
    }
  EXPECT_EQ(JointNet(10, 0.125)(torch::zeros({2, 4, 48, 32})).sizes(), (std::vector<int64_t>{2, 10, 48, 32}));
  FinetuneNet finetune(0.125);
  EXPECT_EQ(finetune(torch::zeros({1, 4, 32, 48}), torch::zeros({1, 10, 32, 48})).sizes(),
            (std::vector<int64_t>{1, 10, 32, 48}));
}

TEST(Networks, RefuseOtherSizes) {
  PriorNet prior(4, 0.125);
  EXPECT_THROW(prior(torch::zeros({1, 4, 40, 32})), std::invalid_argument);
  EXPECT_THROW(prior(torch::zeros({1, 3, 32, 32})), std::invalid_argument);
  EXPECT_THROW(JointNet(10, 0.125)(torch::zeros({1, 4, 40, 32})), std::invalid_argument);
  EXPECT_THROW(FinetuneNet(0.125)(torch::zeros({1, 4, 32, 32}), torch::zeros({1, 4, 32, 32})),
               std::invalid_argument);
}

TEST(FinetuneNet, IgnoresTheMapsBackground) {
  torch::NoGradGuard no_gradients;
  FinetuneNet net(0.125);
  Tensor input = torch::rand({1, 4, 32, 32}) * 2 - 1, maps = torch::rand({1, 10, 32, 32});
  input.select(1, 3).fill_(-1);
  input.select(1, 3).slice(2, 8, 24).fill_(1);
  const Tensor before = net(input, maps);
  maps.slice(3, 0, 8).fill_(0.9);
  EXPECT_TRUE(before.equal(net(input, maps)));
}

// What refining is for: before it has learnt anything it does no harm, and its first gradients say what to
// change.
TEST(JointNet, GivesItsMapsBackWhereItRefinesAndHasNotLearnt) {
  JointNet net(10, 0.125, true);
  const Tensor input = torch::rand({2, 4, 32, 32}) * 2 - 1, maps = torch::rand({2, 10, 32, 32});
  const Tensor output = net(input, maps);
  const double least = JointNetImpl::kLeastGuidance;
  EXPECT_TRUE(torch::allclose(output, maps.clamp(least, 1 - least), 1e-5, 1e-6));
  (output - 0.5).square().sum().backward();
  EXPECT_GT(net->head->weight.grad().abs().max().item<float>(), 0);
  // Maps of 0 and 1 have no logit.
  EXPECT_TRUE(net(input, maps.round()).isfinite().all().item<bool>());
  EXPECT_THROW(net(input, maps.slice(1, 0, 4)), std::invalid_argument);
}

TEST(Networks, EveryParameterGetsAGradient) {
  FinetuneNet net(0.125);
  JointNet joint(10, 0.125), refining(10, 0.125, true);
  torch::nn::init::normal_(refining->head->weight);  // at 0 nothing below it has a gradient
  const Tensor input = torch::rand({1, 4, 32, 32}) * 2 - 1, maps = torch::rand({1, 10, 32, 32});
  net(input, maps).square().sum().backward();
  joint(input).square().sum().backward();
  refining(input, maps).square().sum().backward();
  for (const torch::nn::Module* module :
       {static_cast<torch::nn::Module*>(net.get()), static_cast<torch::nn::Module*>(joint.get()),
        static_cast<torch::nn::Module*>(refining.get())})
    for (const auto& parameter : module->named_parameters())
      EXPECT_TRUE(parameter.value().grad().defined() &&
                  parameter.value().grad().abs().max().item<float>() > 0)
          << parameter.key();
}

// Pixels that were gathered two by two come back to where they were: with all else cut off, the head's own
// view of the picture, or of the maps that it refines, decides each pixel by itself.
TEST(JointNet, SeesEachPixelWhereItPutsItOut) {
  torch::NoGradGuard no_gradients;
  const Tensor input = torch::rand({2, 4, 32, 48}) * 2 - 1, maps = 0.1 + 0.8 * torch::rand({2, 10, 32, 48});
  for (const bool refines : {false, true}) {
    JointNet net(10, 0.125, refines);
    net->head->weight.zero_();
    net->head->bias.zero_();
    // Output 0 at place p of the four is channel 1 of the input, or of the maps, at place p.
    const int64_t seen = refines ? 4 + 10 : 4, wanted = refines ? 4 + 1 : 1;
    const int64_t trunk = net->head->weight.size(1) - 4 * seen;
    for (int64_t p = 0; p < 4; ++p) net->head->weight[p][trunk + 4 * wanted + p].fill_(3);
    const Tensor output = net(input, maps);
    const Tensor covered = 0.5 * (input.select(1, 3) + 1);
    const Tensor expected = refines
                                ? torch::logit(maps.select(1, 0)) + 3 * (2 * maps.select(1, 1) - 1) * covered
                                : 3 * input.select(1, 1);
    EXPECT_TRUE(torch::allclose(output.select(1, 0), torch::sigmoid(expected), 1e-4, 1e-5)) << refines;
    const Tensor others = output.slice(1, 1);
    EXPECT_TRUE(torch::allclose(others, refines ? maps.slice(1, 1) : torch::full_like(others, 0.5)))
        << refines;
  }
}

}  // namespace
}  // namespace ohb
