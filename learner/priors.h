// What estimates maps from a picture alone: the three priors as one network, or the joint one.
#pragma once

#include <filesystem>
#include <map>
#include <vector>

#include "learner/task.h"

namespace ohb::learner {

/// Whether a set of priors must be whole.
enum class PriorsNeeded { kAll, kAny };

/// The priors' ten channels side by side, in the order of the finetuning model, without gradients; NaN in
/// those of a prior that is not there. Throws InputError unless `priors` are one of geometry, albedo and rss
/// each, in any order (kAny: at least one of them, none twice), or one joint network.
class PriorSet {
 public:
  explicit PriorSet(const std::vector<std::filesystem::path>& files_or_runs,
                    PriorsNeeded needed = PriorsNeeded::kAll);
  bool is_joint() const { return networks_.count(Task::kJoint) > 0; }
  bool is_whole() const { return is_joint() || networks_.size() == kPriorTasks.size(); }
  const std::map<Task, Network>& networks() const { return networks_; }
  void move_to(const torch::Device& device);
  /// Of the picture alone: a finetuning model's guidance. On the networks' device, as `input` must be.
  torch::Tensor guidance(const torch::Tensor& input) const;
  /// two_sided_output of it.
  torch::Tensor estimate(const torch::Tensor& input) const;

 private:
  std::map<Task, Network> networks_;
};

}  // namespace ohb::learner
