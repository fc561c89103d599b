// Loops over threads for what knows no libtorch. at::parallel_for is a loop over one thread wherever a file
// is compiled without OpenMP, as those of the learner are.
#pragma once

#include <cstdint>

namespace ohb::learner {

/// Runs body(i, context) for i in [0, count), in any order, on any threads.
using ParallelFor = void (*)(int64_t count, void (*body)(int64_t i, void* context), void* context);

/// On OpenMP's threads, as many as torch::get_num_threads says.
void openmp_parallel_for(int64_t count, void (*body)(int64_t i, void* context), void* context);

/// The same for any callable.
template <typename Body>
void for_each(int64_t count, ParallelFor parallel_for, Body body) {
  parallel_for(
      count, [](int64_t i, void* context) { (*static_cast<Body*>(context))(i); }, &body);
}

}  // namespace ohb::learner
