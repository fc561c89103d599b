#include "learner/constant_loss.h"

namespace ohb::learner {

double constant_map_loss(Task task, const MaterialMaps& truth, const torch::Tensor& mask, bool balanced) {
  const torch::NoGradGuard no_gradients;
  torch::Tensor constant = encoded_maps(task, truth).clone();
  const torch::Tensor inside = mask.select(1, 0) > 0.5;
  for (int64_t channel = 0; channel < constant.size(1); ++channel) {
    const torch::Tensor values = constant.select(1, channel).masked_select(inside);
    if (values.numel() > 0) constant.select(1, channel).copy_(values.median());
  }
  return losses_of(task, constant, truth, mask, {}, {0, {}, balanced}).map.item<double>();
}

}  // namespace ohb::learner
