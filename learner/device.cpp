#include "learner/device.h"

#include <ATen/Context.h>

#include <algorithm>

#include "dataset/model/error.h"

namespace ohb::learner {
namespace {

constexpr const char* kMend = "give --device cpu";
constexpr size_t kMostDigits = 3;

/// The number behind "cuda:"; -1 if that is not what it is.
int number_in(const std::string& name) {
  const std::string prefix = "cuda:";
  const std::string digits = name.rfind(prefix, 0) == 0 ? name.substr(prefix.size()) : "";
  const bool is_number =
      std::all_of(digits.begin(), digits.end(), [](char c) { return c >= '0' && c <= '9'; });
  return digits.empty() || digits.size() > kMostDigits || !is_number ? -1 : std::stoi(digits);
}

}  // namespace

CudaDevices cuda_devices() {
  return {at::Context::hasCUDART(), static_cast<int64_t>(torch::cuda::device_count())};
}

torch::Device device_of(const std::string& name, const CudaDevices& cuda) {
  if (name == "cpu" || (name == "auto" && cuda.count == 0)) return torch::kCPU;
  const int number = name == "cuda" || name == "auto" ? 0 : number_in(name);
  const std::string option = "--device " + name;
  if (number < 0)
    throw InputError("", option, "is none of auto, cpu, cuda, and cuda:N with N from 0 on", kMend);
  if (!cuda.in_libtorch)
    throw InputError("", option, "needs a libtorch with CUDA, which this one was built without", kMend);
  if (number >= cuda.count)
    throw InputError("", option,
                     cuda.count == 0 ? "finds no GPU: libtorch sees none"
                                     : "is not there: libtorch sees " + std::to_string(cuda.count) +
                                           (cuda.count == 1 ? " GPU" : " GPUs") + ", counted from 0",
                     kMend);
  return {torch::kCUDA, static_cast<c10::DeviceIndex>(number)};
}

}  // namespace ohb::learner
