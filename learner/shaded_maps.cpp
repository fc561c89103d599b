#include "learner/shaded_maps.h"

#include <stdexcept>
#include <string>

namespace ohb::learner {
namespace {

using torch::Tensor;
using torch::autograd::AutogradContext;
using torch::autograd::variable_list;

void check(const MaterialMaps& maps, const Tensor& mask, torch::Dtype type, const char* whose) {
  for (const LearnedMap* shaded : kShadedMaps) {
    const Tensor& map = maps.*shaded->tensor;
    if (!map.defined() || map.dim() != 4 || map.size(0) != mask.size(0) ||
        map.size(1) != static_cast<int64_t>(shaded->channels.size()) || map.size(2) != mask.size(2) ||
        map.size(3) != mask.size(3))
      throw std::invalid_argument(std::string(shaded->name) + " of the " + whose +
                                  " has another shape than (B, C, H, W) of the mask");
    if (map.scalar_type() != type || map.device() != mask.device())
      throw std::invalid_argument(std::string(shaded->name) + " of the " + whose +
                                  " is of another type, or on another device, than the rest");
  }
}

/// Backward scales what is known already.
class KnownGradients : public torch::autograd::Function<KnownGradients> {
 public:
  static Tensor forward(AutogradContext* context, at::TensorList /*maps*/, const Tensor& value,
                        const ShadedMaps& gradients) {
    for (size_t i = 0; i < gradients.size(); ++i) context->saved_data[std::to_string(i)] = gradients[i];
    return value.clone();
  }

  static variable_list backward(AutogradContext* context, variable_list outer) {
    // Handed over, not copied: a second copy of the planes would double the memory.
    auto& saved = context->saved_data;
    if (saved.empty()) throw std::logic_error("rendering loss: backward may run once");
    variable_list gradients;
    for (size_t i = 0; i < shading::kPlaneCount; ++i) {
      Tensor gradient = saved.at(std::to_string(i)).toTensor();
      saved.erase(std::to_string(i));
      gradients.push_back(gradient.defined() ? gradient.mul_(outer[0]) : Tensor());
    }
    gradients.resize(shading::kPlaneCount + 2);  // value and gradients get none
    return gradients;
  }
};

}  // namespace

ShadedMaps shaded_maps_of(const MaterialMaps& maps) {
  ShadedMaps tensors;
  for (size_t i = 0; i < tensors.size(); ++i) tensors[i] = maps.*kShadedMaps[i]->tensor;
  return tensors;
}

void check_shaded_maps(const MaterialMaps& prediction, const MaterialMaps& truth, const Tensor& mask) {
  if (mask.dim() != 4 || mask.size(1) != 1) throw std::invalid_argument("mask is not (B, 1, H, W)");
  const torch::Dtype type = prediction.normal.scalar_type();
  check(prediction, mask, type, "prediction");
  check(truth, mask, type, "truth");
}

Tensor with_gradients(const Tensor& value, const ShadedMaps& maps, const ShadedMaps& gradients) {
  return KnownGradients::apply(at::TensorList(maps), value, gradients);
}

}  // namespace ohb::learner
