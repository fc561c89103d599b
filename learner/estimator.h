// The trained networks together: from a photograph's foreground to its maps.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "learner/checkpoint.h"
#include "learner/priors.h"

namespace ohb::learner {

class Estimator {
 public:
  /// Files or runs: joint, or one each of geometry, albedo and rss; and finetune or not, in any order; with
  /// kAny some of the priors will do, but not for a finetuning model. Throws InputError as load_network, and
  /// for a network that is missing or given twice. The networks run on `device`; pictures are given, and maps
  /// returned, on the CPU.
  explicit Estimator(const std::vector<std::filesystem::path>& files_or_runs,
                     PriorsNeeded needed = PriorsNeeded::kAll, const torch::Device& device = torch::kCPU);

  /// False: the maps of a prior that is not there are NaN.
  bool is_whole() const { return priors_->is_whole(); }
  /// Whether one network estimates what three priors do.
  bool is_joint() const { return priors_->is_joint(); }
  bool has_finetune() const { return finetune_.has_value(); }
  std::vector<Network> networks() const;
  /// What was read, in the order of the files or runs.
  const std::vector<std::filesystem::path>& files() const { return files_; }
  /// The priors' estimate of input (B, 4, H, W), see network_input. Networks see it at the size that they
  /// were trained at, or its own if that is smaller: larger, they err more. Maps are of the input's size:
  /// output_at_size_of.
  MaterialMaps from_priors(const torch::Tensor& input) const;
  /// The finetuning model's, or the priors' if there is none.
  MaterialMaps estimate(const torch::Tensor& input) const;

  /// Header of the geometry prior or the joint network (of the first one, where there is none): size_px that
  /// it was trained at.
  const nlohmann::json& header() const { return headers_.at(main_); }
  /// Headers of all networks, in the order of the files: whom each was trained on, and whom it held out.
  const std::vector<nlohmann::json>& headers() const { return headers_; }

 private:
  MaterialMaps maps_by(const std::function<torch::Tensor(const torch::Tensor&)>& networks,
                       const torch::Tensor& input) const;

  torch::Device device_;
  std::optional<PriorSet> priors_;
  std::optional<Network> finetune_;
  std::vector<nlohmann::json> headers_;
  std::vector<std::filesystem::path> files_;
  size_t main_ = 0;
};

}  // namespace ohb::learner
