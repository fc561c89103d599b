#include "learner/priors.h"

#include "dataset/model/error.h"
#include "learner/checkpoint.h"

namespace ohb::learner {
namespace fs = std::filesystem;
using torch::Tensor;

PriorSet::PriorSet(const std::vector<fs::path>& files_or_runs, PriorsNeeded needed) {
  for (const fs::path& file : files_or_runs) {
    const LoadedNetwork loaded = load_network(file);
    const Task task = loaded.network.task;
    if (task != Task::kFinetune && !networks_.emplace(task, loaded.network).second)
      throw InputError(file.string(), "", std::string("is a second ") + name_of(task) + " network",
                       "give one of each");
  }
  if (is_joint()) {
    if (networks_.size() > 1)
      throw InputError("", "priors", "there is a joint network, and others that estimate the same",
                       "give the joint one alone, or geometry, albedo and rss");
    return;
  }
  for (const Task task : kPriorTasks)
    if (networks_.count(task) == 0 && (needed == PriorsNeeded::kAll || networks_.empty()))
      throw InputError("", "priors", std::string("there is no ") + name_of(task) + " prior",
                       "give geometry, albedo and rss, or joint");
}

void PriorSet::move_to(const torch::Device& device) {
  for (const auto& [task, network] : networks_) network.module().to(device);
}

Tensor PriorSet::estimate(const Tensor& input) const {
  return two_sided_output(
      Task::kFinetune, [this](const Tensor& x) { return guidance(x); }, input);
}

Tensor PriorSet::guidance(const Tensor& input) const {
  torch::NoGradGuard no_gradients;
  if (is_joint()) return networks_.at(Task::kJoint).forward(input, {});
  std::vector<Tensor> outputs;
  for (const Task task : kPriorTasks) {
    const auto found = networks_.find(task);
    outputs.push_back(found != networks_.end()
                          ? found->second.forward(input, {})
                          : torch::full({input.size(0), output_channels(task), input.size(2), input.size(3)},
                                        std::nan(""), input.options()));
  }
  return torch::cat(outputs, 1);
}

}  // namespace ohb::learner
