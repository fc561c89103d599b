// What options must be, and the learning rate that follows from them.
#include <algorithm>
#include <cmath>

#include "dataset/model/error.h"
#include "learner/train.h"

namespace ohb::learner {
namespace {

constexpr double kFinalRate = 1e-6;

}  // namespace

void check_train_options(const TrainOptions& o) {
  const auto refuse = [](const std::string& place, const std::string& cause) {
    throw InputError("", place, cause, "see humanmaterial train --help");
  };
  if (o.size_px < kResolutionStep || o.size_px % kResolutionStep != 0)
    refuse("--size " + std::to_string(o.size_px), "is no multiple of 16");
  if (!(o.width >= 0.05 && o.width <= 4)) refuse("--width", "is not from 0.05 to 4");
  if (o.batch < 1) refuse("--batch", "is below 1");
  if (o.steps < 0 || (o.steps == 0 && o.epochs < 1)) refuse("--steps", "is below 1");
  if (!(o.learning_rate > 0)) refuse("--learning-rate", "is not above 0");
  if (o.guidance == Guidance::kPriors && o.task != Task::kFinetune)
    refuse("--guidance priors", "is for finetune only");
  if (o.guidance == Guidance::kPriors && o.priors.size() != 3 && o.priors.size() != 1)
    refuse("--priors", "needs geometry, albedo and rss, or joint");
}

double learning_rate_at(const TrainOptions& o, int64_t step, int64_t steps) {
  const int64_t warmup = std::min(o.warmup, steps / 10);
  if (step <= warmup) return o.learning_rate * static_cast<double>(step) / static_cast<double>(warmup);
  if (!o.cosine) return o.learning_rate;
  const double share =
      static_cast<double>(step - warmup) / static_cast<double>(std::max<int64_t>(1, steps - warmup));
  return kFinalRate + (o.learning_rate - kFinalRate) * 0.5 * (1 + std::cos(share * shading::kPi));
}

}  // namespace ohb::learner
