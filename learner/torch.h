// libtorch's C++ API, precompiled once for the folder (target_precompile_headers).
#pragma once

#include <torch/torch.h>
