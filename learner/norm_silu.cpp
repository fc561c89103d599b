#include "learner/norm_silu.h"

#include <ATen/record_function.h>
#include <torch/csrc/jit/frontend/tracer.h>

#include "learner/norm_silu_kernel.h"

namespace ohb::learner {
namespace {

using torch::Tensor;
using torch::autograd::AutogradContext;
using torch::autograd::variable_list;

constexpr auto kLast = torch::MemoryFormat::ChannelsLast;

norm_silu_kernel::Shape shape_of(const Tensor& x, int64_t groups) {
  return {x.size(0), x.size(2) * x.size(3), x.size(1), groups};
}

class NormSilu : public torch::autograd::Function<NormSilu> {
 public:
  static Tensor forward(AutogradContext* context, const Tensor& input, int64_t groups, const Tensor& gain,
                        const Tensor& offset, double epsilon) {
    RECORD_USER_SCOPE("norm_silu");
    const Tensor x = input.contiguous(kLast);
    Tensor y = torch::empty_like(x);
    Tensor mean =
        torch::empty({x.size(0), groups}, x.options().memory_format(torch::MemoryFormat::Contiguous));
    Tensor inverse = torch::empty_like(mean);
    norm_silu_kernel::forward(shape_of(x, groups),
                              {x.data_ptr<float>(), gain.data_ptr<float>(), offset.data_ptr<float>(), epsilon,
                               y.data_ptr<float>(), mean.data_ptr<float>(), inverse.data_ptr<float>()},
                              openmp_parallel_for);
    context->save_for_backward({x, gain, offset, mean, inverse});
    return y;
  }

  static variable_list backward(AutogradContext* context, variable_list outer) {
    RECORD_USER_SCOPE("norm_silu");
    const variable_list saved = context->get_saved_variables();
    const Tensor &x = saved[0], &gain = saved[1], y_gradient = outer[0].contiguous(kLast);
    Tensor x_gradient = torch::empty_like(x), gain_gradient = torch::empty_like(gain),
           offset_gradient = torch::empty_like(gain);
    norm_silu_kernel::backward(
        shape_of(x, saved[3].size(1)),
        {x.data_ptr<float>(), y_gradient.data_ptr<float>(), gain.data_ptr<float>(),
         saved[2].data_ptr<float>(), saved[3].data_ptr<float>(), saved[4].data_ptr<float>(),
         x_gradient.data_ptr<float>(), gain_gradient.data_ptr<float>(), offset_gradient.data_ptr<float>()},
        openmp_parallel_for);
    return {x_gradient, Tensor(), gain_gradient, offset_gradient, Tensor()};
  }
};

}  // namespace

Tensor norm_silu(const Tensor& x, int64_t groups, const Tensor& gain, const Tensor& offset, double epsilon) {
  // Nobody else who reads a recorded network has our kernel.
  if (torch::jit::tracer::isTracing() || !x.device().is_cpu() || x.scalar_type() != torch::kFloat ||
      gain.scalar_type() != torch::kFloat)
    return torch::silu(torch::group_norm(x, groups, gain, offset, epsilon));
  return NormSilu::apply(x, groups, gain.contiguous(), offset.contiguous(), epsilon);
}

}  // namespace ohb::learner
