// On which device networks are trained and evaluated.
#pragma once

#include <cstdint>
#include <string>

#include "learner/torch.h"

namespace ohb::learner {

/// What this libtorch and this machine have.
struct CudaDevices {
  bool in_libtorch = false;  // libtorch was built with CUDA
  int64_t count = 0;         // GPUs that it sees
};
CudaDevices cuda_devices();

/// "cpu"; "cuda", the first GPU; "cuda:N", the GPU of that number, from 0; "auto": "cuda" if there is one,
/// else "cpu". Throws InputError for another name, and for a GPU that is not there: it says whether libtorch
/// lacks CUDA or sees no such GPU.
torch::Device device_of(const std::string& name, const CudaDevices& cuda = cuda_devices());

}  // namespace ohb::learner
