// AdamW (Loshchilov and Hutter 2019). libtorch has one too, but before 2.4 it forgets its options in files,
// and its state is keyed by addresses; this one's state is two tensors a parameter.
#pragma once

#include <string>
#include <vector>

#include "learner/torch.h"

namespace ohb::learner {

class AdamW {
 public:
  struct Options {
    double weight_decay = 0.01;  // of parameters with two or more dimensions: not of biases and norms
    double beta1 = 0.9, beta2 = 0.999, epsilon = 1e-8;
    double average_decay = 0;  // of State::average, a step; 0: none is kept
  };
  AdamW(const torch::nn::Module& module, Options options);

  /// One update with the gradients at hand; `step` counts from 1.
  void update(double learning_rate, int64_t step);
  void clear_gradients();
  /// Scales all gradients so that their common norm is at most `limit`; returns the norm before (NaN or
  /// infinite if any is, and then nothing is scaled).
  double clip_gradients(double limit);

  /// Gives each parameter the value of its average, where one is kept.
  void take_averages();

  struct State {
    std::string name;
    torch::Tensor parameter, first, second;  // the moments
    torch::Tensor average;  // of the parameter over the last 1 / (1 - average_decay) steps; undefined: none
  };
  /// In the module's order. Tensors may be copied into.
  std::vector<State>& states() { return states_; }

 private:
  Options options_;
  std::vector<State> states_;
};

}  // namespace ohb::learner
