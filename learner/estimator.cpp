#include "learner/estimator.h"

#include "dataset/model/error.h"

namespace ohb::learner {

Estimator::Estimator(const std::vector<std::filesystem::path>& files_or_runs, PriorsNeeded needed) {
  std::vector<std::filesystem::path> priors;
  for (const auto& file : files_or_runs) {
    LoadedNetwork loaded = load_network(file);
    if (loaded.network.task == Task::kFinetune) {
      if (finetune_) throw InputError(file.string(), "", "is a second finetuning model", "give one");
      finetune_ = loaded.network;
    } else {
      priors.push_back(file);
    }
    if (loaded.network.task == Task::kGeometry) main_ = headers_.size();
    headers_.push_back(loaded.header);
  }
  priors_.emplace(priors, finetune_ ? PriorsNeeded::kAll : needed);
}

MaterialMaps Estimator::from_priors(const torch::Tensor& input) const {
  torch::NoGradGuard no_gradients;
  return maps_of(Task::kFinetune, priors_->estimate(input), {});
}

MaterialMaps Estimator::estimate(const torch::Tensor& input) const {
  if (!finetune_) return from_priors(input);
  torch::NoGradGuard no_gradients;
  return maps_of(Task::kFinetune, finetune_->forward(input, priors_->estimate(input)), {});
}

}  // namespace ohb::learner
