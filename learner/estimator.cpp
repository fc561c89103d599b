#include "learner/estimator.h"

#include "dataset/model/error.h"
#include "learner/upsample.h"

namespace ohb::learner {
Estimator::Estimator(const std::vector<std::filesystem::path>& files_or_runs, PriorsNeeded needed,
                     const torch::Device& device)
    : device_(device) {
  std::vector<std::filesystem::path> priors;
  for (const auto& file : files_or_runs) {
    LoadedNetwork loaded = load_network(file);
    if (loaded.network.task == Task::kFinetune) {
      if (finetune_) throw InputError(file.string(), "", "is a second finetuning model", "give one");
      finetune_ = loaded.network;
    } else {
      priors.push_back(file);
    }
    if (loaded.network.task == Task::kGeometry || loaded.network.task == Task::kJoint)
      main_ = headers_.size();
    headers_.push_back(loaded.header);
    files_.push_back(loaded.file);
  }
  priors_.emplace(priors, finetune_ ? PriorsNeeded::kAll : needed);
  priors_->move_to(device);
  if (finetune_) finetune_->module().to(device);
}

std::vector<Network> Estimator::networks() const {
  std::vector<Network> all;
  for (const auto& [task, network] : priors_->networks()) all.push_back(network);
  if (finetune_) all.push_back(*finetune_);
  return all;
}

MaterialMaps Estimator::maps_by(const std::function<torch::Tensor(const torch::Tensor&)>& networks,
                                const torch::Tensor& input) const {
  torch::NoGradGuard no_gradients;
  const int64_t size_px = header().at("size_px");
  const auto output = [&](const torch::Tensor& x) { return networks(x.to(device_)).to(x.device()); };
  if (input.size(2) <= size_px) return maps_of(Task::kFinetune, output(input), {});
  const torch::Tensor small = averaged_input(input, size_px);
  return maps_of(Task::kFinetune, output_at_size_of(input, output(small), small), {});
}

MaterialMaps Estimator::from_priors(const torch::Tensor& input) const {
  return maps_by([this](const torch::Tensor& x) { return priors_->estimate(x); }, input);
}

MaterialMaps Estimator::estimate(const torch::Tensor& input) const {
  if (!finetune_) return from_priors(input);
  return maps_by(
      [this](const torch::Tensor& picture) {
        const auto refined = [this](const torch::Tensor& x) {
          return finetune_->forward(x, priors_->guidance(x));
        };
        return two_sided_output(Task::kFinetune, refined, picture);
      },
      input);
}

}  // namespace ohb::learner
