#include "learner/conv.h"

#include <ATen/record_function.h>
#include <torch/csrc/jit/frontend/tracer.h>

#include "learner/conv_kernel.h"

namespace ohb::learner {
namespace {

using torch::Tensor;
using torch::autograd::AutogradContext;
using torch::autograd::variable_list;

constexpr auto kLast = torch::MemoryFormat::ChannelsLast;
thread_local bool is_plain = false;

conv_kernel::Shape shape_of(const Tensor& x, const Tensor& weight, int64_t stride) {
  return {x.size(0), x.size(2), x.size(3), x.size(1), weight.size(0), stride, weight.size(2)};
}

/// x channels last.
Tensor convolved(const Tensor& x, const Tensor& weight, const c10::optional<Tensor>& bias, int64_t stride) {
  RECORD_USER_SCOPE("conv");
  const conv_kernel::Shape shape = shape_of(x, weight, stride);
  Tensor y = torch::empty({shape.images, shape.channels_out, shape.height_out(), shape.width_out()},
                          x.options().memory_format(kLast));
  conv_kernel::forward(shape, x.data_ptr<float>(), weight.contiguous().data_ptr<float>(),
                       bias ? bias->data_ptr<float>() : nullptr, y.data_ptr<float>(), openmp_parallel_for);
  return y;
}

/// Of a convolution whose weights are the others' turned by half a turn, for stride 1.
Tensor picture_gradient(const Tensor& y_gradient, const Tensor& x, const Tensor& weight, int64_t stride) {
  if (stride == 1 && weight.size(1) % conv_kernel::kBlock == 0)
    return convolved(y_gradient, weight.flip({2, 3}).transpose(0, 1), c10::nullopt, 1);
  return std::get<0>(torch::convolution_backward(y_gradient, x, weight, c10::nullopt, {stride, stride},
                                                 {weight.size(2) / 2, weight.size(2) / 2}, {1, 1}, false,
                                                 {0, 0}, 1, {true, false, false}));
}

Tensor weight_gradient(const Tensor& y_gradient, const Tensor& x, const Tensor& weight, int64_t stride) {
  if (weight.size(2) == 1)  // a matrix product over pixels
    return torch::mm(y_gradient.permute({0, 2, 3, 1}).reshape({-1, weight.size(0)}).t(),
                     x.permute({0, 2, 3, 1}).reshape({-1, weight.size(1)}))
        .view(weight.sizes());
  RECORD_USER_SCOPE("conv");
  Tensor gradient = torch::empty(weight.sizes(), weight.options());
  conv_kernel::weight_gradient(shape_of(x, weight, stride), x.data_ptr<float>(), y_gradient.data_ptr<float>(),
                               gradient.data_ptr<float>(), openmp_parallel_for);
  return gradient;
}

class Convolution : public torch::autograd::Function<Convolution> {
 public:
  static Tensor forward(AutogradContext* context, const Tensor& x, const Tensor& weight,
                        const c10::optional<Tensor>& bias, int64_t stride) {
    context->save_for_backward({x, weight});
    context->saved_data["stride"] = stride;
    context->saved_data["has bias"] = bias.has_value();
    return convolved(x, weight, bias, stride);
  }

  static variable_list backward(AutogradContext* context, variable_list outer) {
    const variable_list saved = context->get_saved_variables();
    const Tensor &x = saved[0], &weight = saved[1], y_gradient = outer[0].contiguous(kLast);
    const int64_t stride = context->saved_data["stride"].toInt();
    return {x.requires_grad() ? picture_gradient(y_gradient, x, weight, stride) : Tensor(),
            weight_gradient(y_gradient, x, weight, stride),
            context->saved_data["has bias"].toBool() ? y_gradient.sum({0, 2, 3}) : Tensor(), Tensor()};
  }
};

/// Nobody else who reads a recorded network has our kernel.
bool is_for_kernel(const Tensor& x, const Tensor& weight) {
  const bool any_in = weight.size(2) == 1;
  return conv_kernel::pays() && !is_plain && !torch::jit::tracer::isTracing() && x.device().is_cpu() &&
         x.scalar_type() == torch::kFloat && weight.scalar_type() == torch::kFloat &&
         (any_in || x.size(1) % conv_kernel::kBlock == 0) && weight.size(0) % conv_kernel::kBlock == 0;
}

/// What a function of autograd takes for a tensor that may not be there.
c10::optional<Tensor> optional(const Tensor& tensor) {
  return tensor.defined() ? c10::optional<Tensor>(tensor) : c10::nullopt;
}

}  // namespace

PlainConvolutions::PlainConvolutions() : before_(is_plain) {
  is_plain = true;
}

PlainConvolutions::~PlainConvolutions() {
  is_plain = before_;
}

Tensor conv3x3(const Tensor& x, const torch::nn::Conv2d& layer) {
  const int64_t stride = layer->options.stride()->at(0);
  if (is_for_kernel(x, layer->weight))
    return Convolution::apply(x.contiguous(kLast), layer->weight, optional(layer->bias), stride);
  return torch::conv2d(x, layer->weight, layer->bias, stride, 1);
}

Tensor pointwise(const Tensor& x, const Tensor& weight, const Tensor& bias) {
  if (is_for_kernel(x, weight)) return Convolution::apply(x.contiguous(kLast), weight, optional(bias), 1);
  return torch::linear(x.permute({0, 2, 3, 1}), weight.flatten(1), bias).permute({0, 3, 1, 2});
}

}  // namespace ohb::learner
