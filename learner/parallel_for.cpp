#include "learner/parallel_for.h"

#include <ATen/Parallel.h>

namespace ohb::learner {

void openmp_parallel_for(int64_t count, void (*body)(int64_t, void*), void* context) {
  const int threads = at::get_num_threads();
#pragma omp parallel for schedule(static) num_threads(threads) if (count > 1)
  for (int64_t i = 0; i < count; ++i) body(i, context);
}

}  // namespace ohb::learner
