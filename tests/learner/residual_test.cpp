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

TEST(Residual, ARunBeginsWhereItsPriorsAre) {
  TemporaryFolder folder;
  write_ball_dataset(folder / "data", 1, 1, 16);
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
  o.priors = weights_in(folder, false);
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

}  // namespace
}  // namespace ohb
