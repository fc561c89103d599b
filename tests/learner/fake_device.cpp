#include "fake_device.h"

#include <c10/core/impl/DeviceGuardImplInterface.h>
#include <torch/library.h>

#include <atomic>
#include <stdexcept>
#include <string>

namespace ohb {
namespace {

using c10::IValue;
using torch::Tensor;

constexpr auto kType = c10::DeviceType::PrivateUse1;
constexpr uintptr_t kTurnedBit = uintptr_t{1} << 55;  // no program's address has it

std::atomic<int64_t> g_calls{0};

void* turned(const void* address) {
  return address ? reinterpret_cast<void*>(reinterpret_cast<uintptr_t>(address) ^ kTurnedBit) : nullptr;
}

bool is_fake(const Tensor& tensor) {
  return tensor.defined() && tensor.device().type() == kType;
}

/// A tensor over that storage with the shape of `like`.
Tensor over(c10::Storage storage, const Tensor& like, c10::DispatchKeySet keys) {
  Tensor tensor = at::detail::make_tensor<c10::TensorImpl>(std::move(storage), keys, like.dtype());
  tensor.unsafeGetTensorImpl()->set_storage_offset(like.storage_offset());
  tensor.unsafeGetTensorImpl()->set_sizes_and_strides(like.sizes(), like.strides());
  return tensor;
}

/// The same memory as seen by the other device; it lives as long as either.
c10::Storage seen_by(const c10::Device& device, const c10::Storage& storage) {
  const auto release = [](void* held) { delete static_cast<c10::Storage*>(held); };
  c10::DataPtr data(turned(storage.data()), new c10::Storage(storage), release, device);
  return {c10::Storage::use_byte_size_t(), storage.nbytes(), std::move(data), nullptr, false};
}

Tensor on_cpu(const Tensor& fake) {
  if (!is_fake(fake)) return fake;
  if (fake.storage().nbytes() == 0) return torch::empty(fake.sizes(), fake.scalar_type());  // may grow
  return over(seen_by(torch::kCPU, fake.storage()), fake, c10::DispatchKeySet(c10::DispatchKey::CPU));
}

/// Module::to needs a backend of which libtorch 1.13 knows that its tensors are dense: XPU counts as one.
c10::DispatchKeySet fake_keys() {
  return c10::DispatchKeySet(c10::DispatchKey::PrivateUse1) |
         c10::DispatchKeySet(c10::BackendComponent::XPUBit);
}

Tensor on_fake(const Tensor& cpu) {
  if (!cpu.defined()) return cpu;
  return over(seen_by(fake_device(), cpu.storage()), cpu, fake_keys());
}

/// Looks at every tensor of the arguments.
template <typename Visit>
void for_tensors(const IValue& value, const Visit& visit) {
  if (value.isTensor()) visit(value.toTensor());
  if (value.isTensorList())
    for (const Tensor& tensor : value.toTensorVector()) visit(tensor);
  if (value.isOptionalTensorList())
    for (const auto& tensor : value.toOptionalTensorVector())
      if (tensor) visit(*tensor);
}

IValue on_cpu(const IValue& value) {
  if (value.isTensor()) return on_cpu(value.toTensor());
  if (value.isDevice()) return c10::Device(torch::kCPU);
  if (value.isTensorList()) {
    c10::List<Tensor> tensors;
    for (const Tensor& tensor : value.toTensorVector()) tensors.push_back(on_cpu(tensor));
    return tensors;
  }
  if (value.isOptionalTensorList()) {
    c10::List<c10::optional<Tensor>> tensors;
    for (const auto& tensor : value.toOptionalTensorVector())
      tensors.push_back(tensor ? c10::optional<Tensor>(on_cpu(*tensor)) : c10::nullopt);
    return tensors;
  }
  return value;
}

void refuse_mixture(const std::string& name, const std::vector<IValue>& arguments) {
  for (const IValue& argument : arguments)
    for_tensors(argument, [&](const Tensor& tensor) {
      if (tensor.defined() && tensor.dim() > 0 && tensor.device().is_cpu())
        throw std::runtime_error(name + " between the fake device and the CPU");
    });
}

/// The argument that a result is (written in place), or is a part of (a view).
const IValue* origin_of(const c10::AliasInfo& alias, const c10::FunctionSchema& schema,
                        const std::vector<IValue>& arguments) {
  for (size_t i = 0; i < arguments.size(); ++i) {
    const auto* info = schema.arguments()[i].alias_info();
    if (info && info->beforeSets() == alias.beforeSets()) return &arguments[i];
  }
  return nullptr;
}

/// What was written in place may have grown from nothing.
void adopt(const Tensor& fake, const Tensor& cpu) {
  if (fake.sizes() == cpu.sizes()) return;
  fake.unsafeGetTensorImpl()->set_storage_keep_dtype(seen_by(fake_device(), cpu.storage()));
  fake.unsafeGetTensorImpl()->set_sizes_and_strides(cpu.sizes(), cpu.strides());
}

IValue on_fake(const IValue& result, const c10::AliasInfo* alias, const IValue* origin) {
  if (origin && alias->isWrite() && result.isTensor()) adopt(origin->toTensor(), result.toTensor());
  if (origin && alias->isWrite()) return *origin;
  if (origin && result.isTensor()) return over(origin->toTensor().storage(), result.toTensor(), fake_keys());
  if (result.isTensor()) return on_fake(result.toTensor());
  if (!result.isTensorList()) return result;
  c10::List<Tensor> tensors;
  for (const Tensor& tensor : result.toTensorVector())
    tensors.push_back(origin ? over(origin->toTensor().storage(), tensor, fake_keys()) : on_fake(tensor));
  return tensors;
}

void run_on_cpu(const c10::OperatorHandle& op, torch::jit::Stack* stack) {
  ++g_calls;
  const c10::FunctionSchema& schema = op.schema();
  const std::vector<IValue> arguments = torch::jit::pop(*stack, schema.arguments().size());
  refuse_mixture(schema.name(), arguments);
  for (const IValue& argument : arguments) stack->push_back(on_cpu(argument));
  op.callBoxed(stack);
  const std::vector<IValue> results = torch::jit::pop(*stack, schema.returns().size());
  for (size_t i = 0; i < results.size(); ++i) {
    const auto* alias = schema.returns()[i].alias_info();
    stack->push_back(on_fake(results[i], alias, alias ? origin_of(*alias, schema, arguments) : nullptr));
  }
}

Tensor empty(at::IntArrayRef size, c10::optional<at::ScalarType> type, c10::optional<at::Layout>,
             c10::optional<at::Device>, c10::optional<bool>, c10::optional<at::MemoryFormat> format) {
  return on_fake(
      torch::empty(size, torch::TensorOptions(type.value_or(torch::kFloat)).memory_format(format)));
}

Tensor empty_strided(at::IntArrayRef size, at::IntArrayRef stride, c10::optional<at::ScalarType> type,
                     c10::optional<at::Layout>, c10::optional<at::Device>, c10::optional<bool>) {
  return on_fake(torch::empty_strided(size, stride, type.value_or(torch::kFloat)));
}

Tensor copy_from(const Tensor& from, const Tensor& to, bool) {
  on_cpu(to).copy_(on_cpu(from));
  return to;
}

c10::OperatorHandle named(const char* name) {
  return c10::Dispatcher::singleton().findSchemaOrThrow(name, "");
}

// libtorch asks devices that it does not know for convolutions of their own.

void convolution(const c10::OperatorHandle&, torch::jit::Stack* stack) {
  run_on_cpu(named("aten::convolution"), stack);
}

void convolution_backward(const c10::OperatorHandle& op, torch::jit::Stack* stack) {
  std::vector<IValue> arguments = torch::jit::pop(*stack, op.schema().arguments().size());
  // The CPU's has the bias's sizes after the weight.
  const std::vector<int64_t> bias_sizes = {arguments[2].toTensor().size(0)};
  arguments.insert(arguments.begin() + 3, IValue(bias_sizes));
  for (const IValue& argument : arguments) stack->push_back(argument);
  run_on_cpu(named("aten::convolution_backward"), stack);
}

// The registration's macros are libtorch's way in.
C10_REGISTER_GUARD_IMPL(PrivateUse1, c10::impl::NoOpDeviceGuardImpl<kType>)

TORCH_LIBRARY_IMPL(_, PrivateUse1, library) {
  library.fallback(torch::CppFunction::makeFromBoxedFunction<&run_on_cpu>());
}

TORCH_LIBRARY_IMPL(aten, PrivateUse1, library) {
  library.impl("empty.memory_format", empty);
  library.impl("empty_strided", empty_strided);
  library.impl("_copy_from", copy_from);
  library.impl("convolution_overrideable", torch::CppFunction::makeFromBoxedFunction<&convolution>());
  library.impl("convolution_backward_overrideable",
               torch::CppFunction::makeFromBoxedFunction<&convolution_backward>());
}

}  // namespace

torch::Device fake_device() {
  return {kType, 0};
}

int64_t fake_device_calls() {
  return g_calls;
}

}  // namespace ohb
