#include "learner/adamw.h"

#include <algorithm>
#include <cmath>

#include "learner/adamw_kernel.h"
#include "learner/parallel_for.h"

namespace ohb::learner {
namespace {

/// On the CPU. Parameters, and so all tensors made like them, are contiguous.
void update_here(AdamW::State& s, const adamw_kernel::Step& step) {
  constexpr int64_t kGrain = 1 << 16;  // floats worth a thread
  const torch::Tensor gradient = s.parameter.grad().contiguous();
  const adamw_kernel::Arrays all = {gradient.data_ptr<float>(),
                                    s.parameter.data_ptr<float>(),
                                    s.first.data_ptr<float>(),
                                    s.second.data_ptr<float>(),
                                    s.average.defined() ? s.average.data_ptr<float>() : nullptr,
                                    s.parameter.numel()};
  for_each((all.count + kGrain - 1) / kGrain, openmp_parallel_for, [&](int64_t part) {
    const int64_t begin = part * kGrain, end = std::min(all.count, begin + kGrain);
    adamw_kernel::update(step,
                         {all.gradient + begin, all.parameter + begin, all.first + begin, all.second + begin,
                          all.average ? all.average + begin : nullptr, end - begin});
  });
}

/// The same by libtorch's operators, on any device.
void update_there(AdamW::State& s, const adamw_kernel::Step& step) {
  const torch::Tensor gradient = s.parameter.grad();
  s.first.mul_(step.beta1).add_(gradient, 1 - step.beta1);
  s.second.mul_(step.beta2).addcmul_(gradient, gradient, 1 - step.beta2);
  s.parameter.mul_(step.keep).addcdiv_(s.first, s.second.sqrt().mul_(step.second_scale).add_(step.epsilon),
                                       -step.rate);
  if (s.average.defined()) s.average.lerp_(s.parameter, step.average_weight);
}

}  // namespace

AdamW::AdamW(const torch::nn::Module& module, Options options) : options_(options) {
  for (const auto& item : module.named_parameters())
    states_.push_back({item.key(), item.value(), torch::zeros_like(item.value()),
                       torch::zeros_like(item.value()),
                       options.average_decay > 0 ? item.value().detach().clone() : torch::Tensor()});
}

void AdamW::update(double learning_rate, int64_t step) {
  torch::NoGradGuard no_gradients;
  const double correction1 = 1 - std::pow(options_.beta1, static_cast<double>(step));
  const double correction2 = 1 - std::pow(options_.beta2, static_cast<double>(step));
  // Of few steps all count alike: the start must not weigh for long.
  const double decay =
      std::min(options_.average_decay, static_cast<double>(step) / (10.0 + static_cast<double>(step)));
  for (State& s : states_) {
    if (!s.parameter.grad().defined()) continue;
    adamw_kernel::Step numbers;
    numbers.beta1 = static_cast<float>(options_.beta1);
    numbers.beta2 = static_cast<float>(options_.beta2);
    numbers.epsilon = static_cast<float>(options_.epsilon);
    numbers.keep = static_cast<float>(s.parameter.dim() > 1 ? 1 - learning_rate * options_.weight_decay : 1);
    numbers.rate = static_cast<float>(learning_rate / correction1);
    numbers.second_scale = static_cast<float>(1 / std::sqrt(correction2));
    numbers.average_weight = static_cast<float>(1 - decay);
    if (s.parameter.device().is_cpu() && s.parameter.scalar_type() == torch::kFloat)
      update_here(s, numbers);
    else
      update_there(s, numbers);
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
