// Training that goes nowhere: what it is measured by, and that it is said.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "learner/constant_loss.h"
#include "learner/train.h"
#include "test_maps.h"
#include "test_samples.h"
#include "tests/support/test_files.h"

namespace ohb {
using namespace learner;
namespace {

using torch::Tensor;

constexpr int64_t kSide_px = 16;

// No other constant loses less: tried are many values of each channel.
TEST(ConstantLoss, IsTheLeastOfAnyConstants) {
  const MaterialMaps truth = random_maps(1, kSide_px, kSide_px, torch::kFloat, 11);
  const Tensor mask = torch::ones({1, 1, kSide_px, kSide_px});
  const double least = constant_map_loss(Task::kRss, truth, mask);
  const LossOptions maps_alone = {0};
  for (double r = 0; r <= 1; r += 0.05)
    for (double s = 0; s <= 1; s += 0.05)
      for (double sss = 0; sss <= 1; sss += 0.05) {
        const Tensor output =
            torch::tensor({r, s, sss}, torch::kFloat).view({1, 3, 1, 1}).expand({1, 3, kSide_px, kSide_px});
        EXPECT_GE(losses_of(Task::kRss, output, truth, mask, {}, maps_alone).map.item<double>(),
                  least - 1e-6);
      }
}

TEST(ConstantLoss, OfOneValueIsNothingAndTheBackgroundDoesNotCount) {
  MaterialMaps truth = random_maps(1, kSide_px, kSide_px, torch::kFloat, 12);
  Tensor mask = torch::ones({1, 1, kSide_px, kSide_px});
  EXPECT_GT(constant_map_loss(Task::kRss, truth, mask), 0.01);
  mask.slice(3, 0, 8).zero_();
  for (const LearnedMap& map : kMaps) (truth.*map.tensor).slice(3, 8).fill_(0.5);
  EXPECT_NEAR(constant_map_loss(Task::kRss, truth, mask), 0, 1e-6);
  EXPECT_EQ(constant_map_loss(Task::kRss, truth, torch::zeros_like(mask)), 0);
}

/// Whether the log of a geometry prior's run at that rate says that nothing was learnt.
bool learns_nothing(const TemporaryFolder& folder, const std::string& run, double learning_rate) {
  TrainOptions o;
  o.data = folder / "data";
  o.run = folder / run;
  o.width = 0.125;
  o.size_px = 32;
  o.steps = 150;
  o.learning_rate = learning_rate;
  o.threads = 1;
  o.quiet = true;
  train(o);
  std::ifstream stream(o.run / "log.jsonl");
  for (std::string line; std::getline(stream, line);)
    if (nlohmann::json::parse(line).value("event", "") == "nothing learnt") return true;
  return false;
}

// A rate of 1 saturates the network: each loss is finite, so no step is left out.
TEST(NothingLearnt, IsSaidAfterARateThatSaturates) {
  TemporaryFolder folder;
  write_ball_dataset(folder / "data", 2, 2, 32);
  EXPECT_TRUE(learns_nothing(folder, "wild", 1));
  EXPECT_FALSE(learns_nothing(folder, "sane", 2e-3));
}

}  // namespace
}  // namespace ohb
