// The trained networks together: from a photograph's foreground to the six maps.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "learner/train.h"

namespace ohb {

class Estimator {
 public:
  /// Files or runs: one each of geometry, albedo and rss, and finetune or not, in any order.
  /// Throws InputError as load_network, and for a network that is missing or given twice.
  explicit Estimator(const std::vector<std::filesystem::path>& files_or_runs);

  bool has_finetune() const { return finetune_.has_value(); }
  /// The priors' estimate of input (B, 4, H, W), see network_input.
  MaterialMaps from_priors(const torch::Tensor& input) const;
  /// The finetuning model's, or the priors' if there is none.
  MaterialMaps estimate(const torch::Tensor& input) const;

  /// Header of the geometry prior: size_px it was trained at, people held out.
  const nlohmann::json& header() const { return header_; }

 private:
  std::optional<PriorSet> priors_;
  std::optional<Network> finetune_;
  nlohmann::json header_;
};

}  // namespace ohb
