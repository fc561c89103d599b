#include "learner/adamw_kernel.h"

#include <cmath>

namespace ohb::learner::adamw_kernel {
namespace {

/// With and without an average are two loops, since a test inside would keep either from being vectorised.
template <bool kAverages>
void update_all(const Step& step, const Arrays& a) {
  const float rest1 = 1 - step.beta1, rest2 = 1 - step.beta2;
  float* const __restrict parameter = a.parameter;
  float* const __restrict first = a.first;
  float* const __restrict second = a.second;
  float* const __restrict average = a.average;
  const float* const __restrict gradient = a.gradient;
  for (int64_t i = 0; i < a.count; ++i) {
    const float g = gradient[i];
    const float m = step.beta1 * first[i] + rest1 * g;
    const float v = step.beta2 * second[i] + rest2 * g * g;
    const float p =
        step.keep * parameter[i] - step.rate * m / (std::sqrt(v) * step.second_scale + step.epsilon);
    first[i] = m;
    second[i] = v;
    parameter[i] = p;
    if constexpr (kAverages) average[i] += step.average_weight * (p - average[i]);
  }
}

}  // namespace

void update(const Step& step, const Arrays& arrays) {
  if (arrays.average)
    update_all<true>(step, arrays);
  else
    update_all<false>(step, arrays);
}

}  // namespace ohb::learner::adamw_kernel
