#include "learner/adamw.h"

#include <algorithm>
#include <cmath>

namespace ohb::learner {

AdamW::AdamW(const torch::nn::Module& module, Options options) : options_(options) {
  for (const auto& item : module.named_parameters())
    states_.push_back({item.key(), item.value(), torch::zeros_like(item.value()),
                       torch::zeros_like(item.value()),
                       options.average_decay > 0 ? item.value().detach().clone() : torch::Tensor(),
                       torch::empty_like(item.value())});
}

void AdamW::update(double learning_rate, int64_t step) {
  torch::NoGradGuard no_gradients;
  const double correction1 = 1 - std::pow(options_.beta1, static_cast<double>(step));
  const double correction2 = 1 - std::pow(options_.beta2, static_cast<double>(step));
  // Of few steps all count alike: the start must not weigh for long.
  const double decay =
      std::min(options_.average_decay, static_cast<double>(step) / (10.0 + static_cast<double>(step)));
  for (State& s : states_) {
    const torch::Tensor gradient = s.parameter.grad();
    if (!gradient.defined()) continue;
    s.first.mul_(options_.beta1).add_(gradient, 1 - options_.beta1);
    s.second.mul_(options_.beta2).addcmul_(gradient, gradient, 1 - options_.beta2);
    torch::sqrt_out(s.scratch, s.second).mul_(1 / std::sqrt(correction2)).add_(options_.epsilon);
    if (s.parameter.dim() > 1) s.parameter.mul_(1 - learning_rate * options_.weight_decay);
    s.parameter.addcdiv_(s.first, s.scratch, -learning_rate / correction1);
    if (s.average.defined()) s.average.lerp_(s.parameter, 1 - decay);
  }
}

void AdamW::take_averages() {
  torch::NoGradGuard no_gradients;
  for (State& s : states_)
    if (s.average.defined()) s.parameter.copy_(s.average);
}

void AdamW::clear_gradients() {
  for (State& s : states_) s.parameter.mutable_grad() = torch::Tensor();
}

double AdamW::clip_gradients(double limit) {
  torch::NoGradGuard no_gradients;
  std::vector<torch::Tensor> norms;
  for (const State& s : states_)
    if (s.parameter.grad().defined()) norms.push_back(s.parameter.grad().norm());
  if (norms.empty()) return 0;
  // Brought to the CPU together: each transfer waits for the device.
  const torch::Tensor all = torch::stack(norms).to(torch::kCPU);
  double squared = 0;
  for (int64_t i = 0; i < all.size(0); ++i) squared += std::pow(all[i].item<double>(), 2);
  const double norm = std::sqrt(squared);
  if (std::isfinite(norm) && norm > limit)
    for (State& s : states_)
      if (s.parameter.grad().defined()) s.parameter.mutable_grad().mul_(limit / norm);
  return norm;
}

}  // namespace ohb::learner
