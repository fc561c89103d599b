// A finetuning model that adds to its guidance.
#include <gtest/gtest.h>

#include "learner/estimator.h"
#include "learner/train.h"
#include "test_samples.h"
#include "test_weights.h"
#include "tests/support/test_files.h"

namespace ohb {
using namespace learner;
namespace {

/// A residual finetuning run in folder / "run" that learns nothing to speak of.
TrainOptions untrained(const TemporaryFolder& folder, std::vector<std::filesystem::path> priors) {
  TrainOptions o;
  o.task = Task::kFinetune;
  o.data = folder / "data";
  o.run = folder / "run";
  o.width = 0.125;
  o.size_px = 16;
  o.steps = 1;
  o.learning_rate = 1e-12;
  o.quiet = true;
  o.residual = true;
  o.guidance = Guidance::kPriors;
  o.priors = std::move(priors);
  return o;
}

TEST(Residual, ARunBeginsWhereItsPriorsAre) {
  TemporaryFolder folder;
  write_ball_dataset(folder / "data", 1, 1, 16);
  const TrainOptions o = untrained(folder, weights_in(folder, false));
  train(o);
  std::vector<std::filesystem::path> all = o.priors;
  all.push_back(o.run);
  const Estimator estimator(all);
  const torch::Tensor input = torch::rand({1, 4, 16, 16}) * 2 - 1;
  const MaterialMaps whole = estimator.estimate(input), priors = estimator.from_priors(input);
  EXPECT_TRUE(torch::allclose(whole.diffuse, priors.diffuse, 1e-4, 1e-5));
  EXPECT_TRUE(torch::allclose(whole.roughness, priors.roughness, 1e-4, 1e-5));
  // One that puts out maps is another network.
  TrainOptions other = o;
  other.run = folder / "other";
  other.residual = false;
  other.from = o.run;
  expect_message(input_error_of([&] { train(other); }), {"is another network", "residual finetune"});
}

// The joint network guides it as three priors do; both together are one estimator, in any order.
TEST(Residual, IsGuidedByAJointNetwork) {
  TemporaryFolder folder;
  write_ball_dataset(folder / "data", 1, 1, 16);
  const TrainOptions o = untrained(folder, weights_of({Task::kJoint}, folder));
  train(o);
  const torch::Tensor input = torch::rand({1, 4, 16, 16}) * 2 - 1;
  for (const auto& files : {std::vector<std::filesystem::path>{o.run, o.priors[0]}, {o.priors[0], o.run}}) {
    const Estimator estimator(files);
    EXPECT_TRUE(
        torch::allclose(estimator.estimate(input).diffuse, estimator.from_priors(input).diffuse, 1e-4, 1e-5));
    EXPECT_EQ(estimator.header().at("task"), "joint");
  }
  TrainOptions wrong = o;
  wrong.run = folder / "wrong";
  wrong.priors = weights_of({Task::kRss}, folder);
  expect_message(input_error_of([&] { train(wrong); }), {"there is no geometry prior", "or joint"});
}

}  // namespace
}  // namespace ohb
