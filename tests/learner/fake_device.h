// A device that is not the CPU, for machines without a GPU: operators run on the CPU, but whoever takes it
// for the CPU fails.
#pragma once

#include "learner/torch.h"

namespace ohb {

/// libtorch's PrivateUse1. A tensor's memory is the CPU's at an address with one bit turned, so that reading
/// it by its pointer crashes, as with a GPU's. An operator between a tensor of it and one of the CPU with a
/// dimension or more (which GPUs refuse, too) throws; copies alone go from one to the other. Convolutions and
/// whatever else libtorch has for every device take the same ways through it as on a GPU.
torch::Device fake_device();

/// How many operators have run on it.
int64_t fake_device_calls();

}  // namespace ohb
