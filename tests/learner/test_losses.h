// A rendering loss with its gradients, and how far two of them are apart.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <vector>

#include "learner/fused_loss.h"
#include "test_maps.h"

namespace ohb {
using namespace learner;

inline double relative_error(const torch::Tensor& a, const torch::Tensor& b) {
  return ((a - b).norm() / b.norm().clamp_min(1e-30)).item<double>();
}

/// A loss and its gradients by the six maps; undefined where a map has none.
struct Values {
  double loss;
  std::vector<torch::Tensor> gradients;
};

using Loss =
    std::function<torch::Tensor(const MaterialMaps&, const MaterialMaps&, const torch::Tensor&,
                                const std::vector<shading::Light<double>>&, const shading::Options&)>;

/// Under training_lights(7); every map of the prediction gets a gradient.
inline Values values_of(const Loss& loss, MaterialMaps prediction, const MaterialMaps& truth,
                        const torch::Tensor& mask, const shading::Options& options) {
  require_gradients(prediction);
  const torch::Tensor value = loss(prediction, truth, mask, training_lights(7), options);
  value.backward();
  Values values{value.item<double>(), {}};
  for (torch::Tensor* map : tensors_of(prediction)) values.gradients.push_back(map->grad());
  return values;
}

inline void expect_equal(const Values& mine, const Values& wanted, double value_error,
                         double gradient_error) {
  EXPECT_NEAR(mine.loss, wanted.loss, value_error * std::fabs(wanted.loss));
  for (size_t i = 0; i < mine.gradients.size(); ++i)
    EXPECT_LT(relative_error(mine.gradients[i], wanted.gradients[i]), gradient_error) << kMapNames[i];
}

inline torch::Tensor half_mask(int64_t batch, int64_t size, torch::Dtype type) {
  torch::Tensor mask = torch::zeros({batch, 1, size, size}, type);
  mask.slice(3, 0, size / 2 + 3).fill_(1);
  return mask;
}

/// The ways in which the loss is taken.
struct Case {
  const char* name;
  shading::Options options;
};

inline std::vector<Case> cases() {
  Case srgb{"srgb log", {}}, linear{"srgb linear", {}}, disney{"disney log", {}}, f0{"linear f0", {}};
  linear.options.log_domain = false;
  disney.options.specular = shading::SpecularEncoding::kDisney08;
  f0.options.specular = shading::SpecularEncoding::kLinearF0;
  return {srgb, linear, disney, f0};
}

}  // namespace ohb
