// Runs that go on, told how far.
#include <gtest/gtest.h>

#include "dataset/model/atomic_file.h"
#include "learner/train.h"
#include "test_samples.h"
#include "tests/support/test_files.h"

namespace ohb {
using namespace learner;
namespace {

/// Its weights would be written as those of fewer steps than they saw.
TEST(Resume, NeverGoesBackToFewerSteps) {
  TemporaryFolder folder;
  write_ball_dataset(folder / "data", 1, 1, 16);
  TrainOptions o;
  o.task = Task::kRss;
  o.data = folder / "data";
  o.run = folder / "run";
  o.width = 0.125;
  o.size_px = 16;
  o.steps = 3;
  o.warmup = 0;
  o.quiet = o.resume = true;
  const std::string weights = read_file(train(o).weights);
  o.steps = 2;
  expect_message(input_error_of([&] { train(o); }), {"step_00000003", "--steps 2", "less than the 3 steps"});
  EXPECT_EQ(read_file(o.run / "weights.safetensors"), weights);
}

}  // namespace
}  // namespace ohb
