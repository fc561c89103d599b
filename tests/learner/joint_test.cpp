// One network for all maps, in the place of three priors.
#include <gtest/gtest.h>

#include "learner/estimator.h"
#include "learner/evaluate.h"
#include "test_maps.h"
#include "test_samples.h"
#include "test_weights.h"

namespace ohb {
using namespace learner;
namespace {

using torch::Tensor;

TEST(Joint, EstimatesWhatItsOutputSays) {
  TemporaryFolder folder;
  const auto files = weights_of({Task::kJoint}, folder);
  const Estimator estimator(files);
  EXPECT_TRUE(estimator.is_joint() && estimator.is_whole() && !estimator.has_finetune());
  const Network network = load_network(files[0]).network;
  const torch::NoGradGuard no_gradients;
  torch::manual_seed(1);
  const Tensor input = torch::rand({1, 4, 16, 16}) * 2 - 1;
  const Tensor mirrored = mirrored_output(Task::kJoint, network.forward(input.flip(3), {}));
  MaterialMaps wanted = maps_of(Task::kJoint, (network.forward(input, {}) + mirrored) / 2, {});
  MaterialMaps found = estimator.estimate(input);
  for (size_t i = 0; i < 6; ++i)
    EXPECT_TRUE(torch::allclose(*tensors_of(found)[i], *tensors_of(wanted)[i], 1e-5, 1e-6)) << kMapNames[i];
}

TEST(Joint, StandsAlone) {
  TemporaryFolder folder;
  const auto files = weights_of({Task::kRss, Task::kJoint}, folder);
  for (const PriorsNeeded needed : {PriorsNeeded::kAll, PriorsNeeded::kAny})
    expect_message(input_error_of([&] { Estimator(files, needed); }),
                   {"joint", "others that estimate the same"});
  expect_message(input_error_of([&] { Estimator({files[1], files[1]}); }), {"second joint network"});
}

TEST(Joint, IsJudgedUnderItsName) {
  TemporaryFolder folder;
  write_ball_dataset(folder / "data", 3, 1, 16);
  EvaluateOptions o;
  o.weights = weights_of({Task::kJoint}, folder);
  o.data = folder / "data";
  o.relit.views_a_person = 0;
  o.quiet = true;
  EXPECT_EQ(evaluate(o).rows[0].name, "joint");
}

}  // namespace
}  // namespace ohb
